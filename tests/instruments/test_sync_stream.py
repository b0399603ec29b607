"""The block protocol's driver against a scripted server over a real socket."""

import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentTimeoutError
from gyrotest.instruments.sync_stream import SyncStream
from gyrotest.instruments.sync_stream_settings import SyncStreamSettings
from gyrotest.instruments.synchronous.settings import Trigger
from gyrotest.ports import Selecting, SyncDaq
from gyrotest.records.recording import Auxiliary, Block, SampleFlag
from gyrotest.simulation.clock import VirtualClock
from gyrotest.units import Quantity
from tests.instruments.block_server import CHANNELS, BlockServer, packet, plain, ramp

_RATE_HZ = 1000.0
_CLIPPED = 2**31 - 1

Made = Callable[..., SyncStream]


@pytest.fixture
def make() -> Iterator[Made]:
    made: list[SyncStream] = []

    def source(
        server: BlockServer, settings: SyncStreamSettings | None = None, **keys: Any
    ) -> SyncStream:
        keys = {"clock": VirtualClock(), "io_timeout_s": 1.0} | keys
        made.append(SyncStream(server.resource, settings or SyncStreamSettings(), **keys))
        made[-1].open()
        return made[-1]

    yield source
    for one in made:
        one.close()


def _configured(source: SyncStream) -> SyncStream:
    source.select(("gyro",), ("ua", "ub"))
    source.configure(1.0 / _RATE_HZ)
    return source


def _started(source: SyncStream) -> list[Block]:
    source.start(0, 200)
    return _all(source)


def _all(source: SyncStream) -> list[Block]:
    blocks = []
    while (block := source.fetch()) is not None:
        blocks.append(block)
    return blocks


def test_it_is_a_synchronous_source(make: Made) -> None:
    with BlockServer() as server:
        source = make(server)
        assert isinstance(source, SyncDaq)
        assert isinstance(source, Selecting)
        assert [(one.name, one.unit, one.skew_s) for one in source.channels()] == [
            (one["name"], one["unit"], one["skew_s"]) for one in CHANNELS
        ]


def test_the_sampling_tells_units_skews_and_filter(make: Made) -> None:
    settings = SyncStreamSettings(
        skew={"ub": Quantity(25.0, "us")}, skew_uncertainty=Quantity(0.1, "us")
    )
    with BlockServer() as server:
        source = make(server, settings)
        source.select(("gyro",), ("ub", "ua"))
        sampling = source.configure(0.0001)
    assert sampling.synchronous
    assert sampling.columns == ("gyro", "ub", "ua")
    assert sampling.unit == "V"
    assert sampling.auxiliary == (Auxiliary(name="ub", unit="V"), Auxiliary(name="ua", unit="V"))
    assert sampling.offsets_s == pytest.approx((0.0, 25e-6, 10e-6))
    assert sampling.skew_uncertainty_s == pytest.approx(1e-7)
    assert sampling.filter_hz == 4000.0
    assert sampling.range == pytest.approx(10.0)
    assert sampling.duty == 1.0


def test_skews_are_relative_to_the_first_column(make: Made) -> None:
    with BlockServer() as server:
        source = make(server)
        source.select(("ub",), ("ua",))
        assert source.configure(0.001).offsets_s == pytest.approx((0.0, -10e-6))


def test_every_sample_has_its_place_and_its_value(make: Made) -> None:
    with BlockServer() as server:
        source = _configured(make(server))
        source.start(0, 2500)
        blocks = _all(source)
    values = np.concatenate([one.values for one in blocks])
    assert [one.first for one in blocks] == list(
        np.cumsum([0, *(len(one.flags) for one in blocks)])[:-1]
    )
    np.testing.assert_allclose(values, ramp(0, 2500) * [1e-6, 1e-6, 1e-6], rtol=1e-15)
    np.testing.assert_allclose(np.concatenate([one.time_s for one in blocks]), np.arange(2500) * 1e-3)
    assert not any(one.flags.any() for one in blocks)
    assert source.remarks() == (f"{server.resource} (DAQ-4): no sample lost",)


def test_what_is_sent_is_the_protocol(make: Made) -> None:
    with BlockServer() as server:
        source = _configured(make(server))
        for _ in range(2):
            source.start(0, 250)
            _all(source)
        source.close()
    configure = 'CONFIGURE {"channels":["gyro","ua","ub"],"rate_hz":1000.0,"trigger":"immediate"}'
    start = 'START {"samples":250}'
    assert server.asked == ["IDENTIFY", "STOP", "CHANNELS", configure, start, start]


def test_waiting_moves_the_clock_by_what_the_samples_take(make: Made) -> None:
    clock = VirtualClock()
    with BlockServer() as server:
        source = _configured(make(server, clock=clock))
        source.start(0, 5000)
        began_s = clock.now_s()
        blocks = _all(source)
    assert clock.now_s() - began_s == pytest.approx(1.1, abs=1e-9)
    assert sum(len(one.flags) for one in blocks) == 5000


def test_an_overrun_is_a_gap_that_is_counted(make: Made) -> None:
    def overrun(samples: int) -> bytes:
        before = packet(ramp(0, 100), index=0, sequence=0)
        return before + packet(ramp(130, 70), index=130, sequence=1, flags=3)

    with BlockServer([overrun]) as server:
        source = _configured(make(server))
        source.start(0, 200)
        blocks = _all(source)
        assert [(one.first, len(one.flags)) for one in blocks] == [(0, 100), (130, 70)]
        assert blocks[1].values[0, 0] == pytest.approx(0.13)
        assert source.remarks()[0].endswith("30 samples lost by overrun in 1 gap")


def test_blocks_that_are_missing_are_a_gap_that_is_counted(make: Made) -> None:
    def lost(samples: int) -> bytes:
        before = packet(ramp(0, 100), index=0, sequence=0)
        return before + packet(ramp(150, 50), index=150, sequence=3, flags=2)

    with BlockServer([lost]) as server:
        source = _configured(make(server))
        source.start(0, 200)
        assert [one.first for one in _all(source)] == [0, 150]
        assert source.remarks()[0].endswith("50 samples lost on the way in 1 gap")


def test_samples_lost_at_the_very_end_are_told(make: Made) -> None:
    def cut(samples: int) -> bytes:
        before = packet(ramp(0, 100), index=0, sequence=0)
        return before + packet(ramp(200, 0), index=200, sequence=1, flags=3)

    with BlockServer([cut]) as server:
        source = _configured(make(server))
        source.start(0, 200)
        assert [len(one.flags) for one in _all(source)] == [100]
        assert source.remarks()[0].endswith("100 samples lost by overrun in 1 gap")


@pytest.mark.parametrize("garbage", [b"", b"GBLK and more", b"\x00\xff" * 50])
def test_a_block_with_bad_crc_is_left_out_and_counted(make: Made, garbage: bytes) -> None:
    def spoilt(samples: int) -> bytes:
        parts = [packet(ramp(at, 50), index=at, sequence=at // 50) for at in (0, 100)]
        bad = packet(ramp(50, 50), index=50, sequence=1, spoilt=True)
        return (
            parts[0] + bad + garbage + parts[1] + packet(ramp(150, 50), index=150, sequence=3, flags=2)
        )

    with BlockServer([spoilt]) as server:
        source = _configured(make(server))
        source.start(0, 200)
        assert [(one.first, len(one.flags)) for one in _all(source)] == [(0, 50), (100, 100)]
        told = " ".join(source.remarks())
        assert "50 samples lost on the way in 1 gap" in told
        assert "1 block with bad CRC" in told


def test_a_clipped_output_is_an_overload_and_a_clipped_encoder_a_fault(make: Made) -> None:
    def clipped(samples: int) -> bytes:
        raw = ramp(0, samples)
        raw[3, 0], raw[5, 1], raw[7] = -_CLIPPED, _CLIPPED, _CLIPPED
        return packet(raw, index=0, sequence=0, flags=2)

    with BlockServer([clipped]) as server:
        source = _configured(make(server))
        source.start(0, 10)
        (block,) = _all(source)
        assert block.flags[3] == SampleFlag.OVERLOAD
        assert block.flags[5] == SampleFlag.FAULT
        assert block.flags[7] == SampleFlag.OVERLOAD | SampleFlag.FAULT
        assert np.count_nonzero(block.flags) == 3
        assert "'ua' is clipped in 2 samples" in source.remarks()[1]


def test_after_a_lost_connection_it_goes_on_on_the_grid(make: Made) -> None:
    clock = VirtualClock()

    def half(samples: int) -> bytes:
        return packet(ramp(0, 100), index=0, sequence=0)

    with BlockServer([half, plain]) as server:
        source = _configured(make(server, clock=clock, io_timeout_s=0.2))
        source.start(0, 3000)
        assert source.fetch() is not None
        with pytest.raises(InstrumentTimeoutError, match="no sample has arrived"):
            source.fetch()
        first = source.recover()
        # After sample 100 a second and 0.1 s were waited for the next, 0.2 s then, 0.1 s are for the start.
        assert first == 1500
        source.start(first, 3000)
        assert server.asked[-1] == 'START {"samples":1500}'
        blocks = _all(source)
        assert blocks[0].first == first
        assert blocks[0].values[0, 0] == pytest.approx(0.0)
        assert blocks[-1].first + len(blocks[-1].flags) == 3000
        assert "connected anew 1 time" in " ".join(source.remarks())


def test_a_connection_that_breaks_is_told_at_once(make: Made) -> None:
    with BlockServer([lambda samples: None]) as server:
        source = _configured(make(server))
        with pytest.raises(InstrumentError, match="connection lost"):
            source.start(0, 200)


def test_another_instrument_after_a_fault_is_refused(make: Made) -> None:
    with BlockServer(serials=["1234", "5678"]) as server:
        source = _configured(make(server))
        with pytest.raises(InstrumentIdentityError, match="found serial number 5678, expected 1234"):
            source.recover()


def test_another_serial_number_than_the_stations_is_refused(make: Made) -> None:
    with BlockServer() as server, pytest.raises(InstrumentIdentityError, match="1234, expected 99"):
        make(server, serial_number="99")


def test_an_external_trigger_is_waited_for(make: Made) -> None:
    with BlockServer() as server:
        source = _configured(make(server, SyncStreamSettings(trigger=Trigger.EXTERNAL)))
        source.start(0, 300)
        assert sum(len(one.flags) for one in _all(source)) == 300
        assert '"trigger":"external"' in server.asked[3]


def test_no_trigger_in_time_is_an_error(make: Made) -> None:
    settings = SyncStreamSettings(trigger=Trigger.EXTERNAL, trigger_timeout=Quantity(0.5, "s"))
    with BlockServer([lambda samples: b""]) as server:
        source = _configured(make(server, settings))
        source.start(0, 300)
        with pytest.raises(InstrumentTimeoutError, match=r"no trigger within 0\.5 s"):
            source.fetch()
        assert source.recover() == 0


def test_after_a_recovery_no_second_trigger_is_waited_for_until_the_next_step(make: Made) -> None:
    with BlockServer() as server:
        source = _configured(make(server, SyncStreamSettings(trigger=Trigger.EXTERNAL)))
        source.start(0, 300)
        _all(source)
        first = source.recover()
        source.start(first, first + 100)
        _all(source)
        source.start(0, 300)
        _all(source)
    triggers = [re.search(r'"trigger":"(\w+)"', one) for one in server.asked]
    assert [one[1] for one in triggers if one] == ["external", "immediate", "external"]


def test_an_acquisition_that_was_broken_off_is_stopped_before_the_next(make: Made) -> None:
    def running(samples: int) -> bytes:
        return packet(ramp(0, 100), index=0, sequence=0)

    with BlockServer([running, plain]) as server:
        source = _configured(make(server))
        source.start(0, 300)
        source.fetch()
        source.configure(1.0 / _RATE_HZ)
        source.start(0, 300)
        assert sum(len(one.flags) for one in _all(source)) == 300
    assert server.asked[5] == "STOP"


@pytest.mark.parametrize(
    ("said", "told"),
    [
        (packet(ramp(0, 10, 2), index=0, sequence=0), "block of 2 channels; 3 are configured"),
        (packet(ramp(0, 10), index=0, sequence=0, version=2), "version 2 of the block protocol"),
        (packet(ramp(0, 300), index=0, sequence=0), "300 samples of 200 asked for"),
        (packet(ramp(0, 10), index=0, sequence=0, flags=2), "ended after 10 of 200 samples"),
        (packet(ramp(0, 10), index=0, sequence=0, flags=1), "but not how many"),
        (packet(ramp(0, 10), index=0, sequence=0) * 2, "did it start anew"),
        (b'{"error": "converter too hot; let it cool"}\n', "converter too hot; let it cool"),
        (b'{"hello": 1}\n', "arrived without being asked for"),
    ],
)
def test_what_cannot_be_is_refused(make: Made, said: bytes, told: str) -> None:
    with BlockServer([lambda samples: said]) as server:
        source = _configured(make(server))
        with pytest.raises(InstrumentError, match=told):
            _started(source)


@pytest.mark.parametrize(
    ("answers", "told"),
    [
        ({"CONFIGURE": {"error": "rate too high: 2 kHz at most"}}, "rate too high: 2 kHz at most"),
        (
            {"CONFIGURE": {"rate_hz": 1001.0, "filter_hz": None, "full_scale": 1.0}},
            "samples at 1001 Hz where 1000 Hz is asked for; set the case's interval to 0.000999",
        ),
        ({"CONFIGURE": {"rate_hz": 1000.0}}, "full_scale: Field required"),
        ({"CONFIGURE": {"rate_hz": 1000.0, "full_scale": 0.0}}, "full_scale: Input should be greater"),
        ({"CONFIGURE": b'{"rate_hz": 1e400}\n'}, "rate_hz"),
        ({"CONFIGURE": b"hello\n" * 20}, "no reply to CONFIGURE"),
        ({"CHANNELS": []}, "has the channels"),
        ({"CHANNELS": [CHANNELS[0], CHANNELS[0]]}, "a name of its own"),
        ({"CHANNELS": [CHANNELS[0] | {"scale": 0.0}]}, "gives gyro no scale or skew"),
        ({"CHANNELS": [CHANNELS[0] | {"unit": "furlong"}]}, "channel 'gyro'"),
    ],
)
def test_answers_that_cannot_be_are_refused(make: Made, answers: dict[str, Any], told: str) -> None:
    with BlockServer(answers=answers) as server:

        def prepare() -> None:
            source = make(server, io_timeout_s=0.2)
            source.select(("gyro",), ())
            source.configure(1.0 / _RATE_HZ)

        with pytest.raises(InstrumentError, match=told) as caught:
            prepare()
    assert str(caught.value).startswith(server.resource)


@pytest.mark.parametrize(
    ("outputs", "auxiliary", "told"),
    [
        (
            ("giro",),
            (),
            "no channel 'giro', which the slot names; it has gyro, ua, ub; did you mean 'gyro'",
        ),
        (("gyro",), ("theta",), "no channel 'theta'"),
        ((), ("gyro", "ua", "ub"), "no channel is left for the gyro"),
    ],
)
def test_channels_that_are_not_there_are_refused(
    make: Made, outputs: tuple[str, ...], auxiliary: tuple[str, ...], told: str
) -> None:
    with BlockServer() as server:
        source = make(server)
        source.select(outputs, auxiliary)
        with pytest.raises(InstrumentError, match=re.escape(told)):
            source.configure(0.001)


def test_an_angle_is_no_gyros_output_but_may_stand_beside_it(make: Made) -> None:
    channels = [CHANNELS[0], {"name": "angle", "unit": "rad", "scale": 1e-6, "skew_s": 0.0}]
    with BlockServer(answers={"CHANNELS": channels}) as server:
        source = make(server)
        source.select(("gyro",), ("angle",))
        assert source.configure(0.001).auxiliary == (Auxiliary(name="angle", unit="deg"),)
        source.select((), ())
        with pytest.raises(InstrumentError, match="'angle' is in rad, and a gyro's output is a voltage"):
            source.configure(0.001)


def test_a_filter_or_skew_that_does_not_fit_is_refused(make: Made) -> None:
    with BlockServer() as server:
        source = make(server, SyncStreamSettings(filter=Quantity(2.0, "kHz")))
        with pytest.raises(
            InstrumentError, match="its filter cuts off at 4000 Hz, the station says 2 kHz"
        ):
            source.configure(0.001)
        source.close()
        source = make(server, SyncStreamSettings(skew={"uc": Quantity(1.0, "us")}))
        with pytest.raises(InstrumentError, match="no channel 'uc', which the station's 'skew' names"):
            source.configure(0.001)


def test_the_stations_filter_counts_where_the_instrument_does_not_know_its_own(make: Made) -> None:
    answer = {"rate_hz": 1000.0, "filter_hz": None, "full_scale": 1.0}
    with BlockServer(answers={"CONFIGURE": answer}) as server:
        source = make(server, SyncStreamSettings(filter=Quantity(2.0, "kHz")))
        assert source.configure(0.001).filter_hz == pytest.approx(2000.0)


def test_settings_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match="trigger_timeout 0 s is not more than zero"):
        SyncStreamSettings(trigger_timeout=Quantity(0.0, "s"))
    with pytest.raises(ValueError, match="skew_uncertainty -1 us is a half-width"):
        SyncStreamSettings(skew_uncertainty=Quantity(-1.0, "us"))
