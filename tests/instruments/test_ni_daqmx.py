"""The driver of NI devices against a fake of the package's documented interface."""

import inspect
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentTimeoutError
from gyrotest.instruments.ni_daqmx import NiDaqmx
from gyrotest.instruments.ni_daqmx_settings import Coupling, NiDaqmxSettings, Wiring
from gyrotest.instruments.synchronous.settings import Trigger
from gyrotest.ports import SyncDaq
from gyrotest.records.recording import Block, SampleFlag
from gyrotest.simulation.clock import VirtualClock
from gyrotest.units import Quantity
from tests.instruments import fake_nidaqmx
from tests.instruments.fake_nidaqmx import FakeDevice

_TERMINALS = {"gyro": "ai0", "ua": "ai1", "ub": "ai2"}

Made = Callable[..., NiDaqmx]


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> FakeDevice:
    return fake_nidaqmx.install(monkeypatch, FakeDevice())


@pytest.fixture
def make() -> Iterator[Made]:
    made: list[NiDaqmx] = []

    def source(
        resource: str = "Dev1", *, keys: dict[str, Any] | None = None, **settings: Any
    ) -> NiDaqmx:
        settings = {"terminals": _TERMINALS} | settings
        keys = {"clock": VirtualClock()} | (keys or {})
        made.append(NiDaqmx(resource, NiDaqmxSettings(**settings), **keys))
        made[-1].open()
        return made[-1]

    yield source
    for one in made:
        one.close()


def _configured(source: NiDaqmx, interval_s: float = 1e-3) -> NiDaqmx:
    source.select(("gyro",), ("ua", "ub"))
    source.configure(interval_s)
    return source


def _all(source: NiDaqmx) -> list[Block]:
    blocks = []
    while (block := source.fetch()) is not None:
        blocks.append(block)
    return blocks


def test_the_identity_is_the_devices(device: FakeDevice, make: Made) -> None:
    source = NiDaqmx("Dev1", NiDaqmxSettings(terminals=_TERMINALS), clock=VirtualClock())
    identity = source.open()
    assert (identity.manufacturer, identity.model) == ("National Instruments", "PCIe-6343")
    assert identity.serial_number == "01A2B3C4"
    assert isinstance(source, SyncDaq)
    assert [one.name for one in source.channels()] == ["gyro", "ua", "ub"]


def test_a_simulated_device_is_marked_as_such(device: FakeDevice, make: Made) -> None:
    device.is_simulated = True
    assert make().open().simulated


def test_one_converter_for_all_channels_makes_skews(device: FakeDevice, make: Made) -> None:
    source = make(skew_uncertainty=Quantity(50.0, "ns"), filter=Quantity(4.0, "kHz"))
    source.select(("gyro",), ("ua", "ub"))
    sampling = source.configure(1e-4)
    assert sampling.synchronous
    assert sampling.columns == ("gyro", "ua", "ub")
    assert sampling.offsets_s == pytest.approx((0.0, 10e-6, 20e-6))
    assert sampling.skew_uncertainty_s == pytest.approx(50e-9)
    assert sampling.filter_hz == pytest.approx(4000.0)
    assert sampling.unit == "V"
    assert sampling.range == pytest.approx(10.0)
    assert [one.skew_s for one in source.channels()] == pytest.approx([0.0, 10e-6, 20e-6])


def test_simultaneous_channels_have_none_and_the_station_goes_before(
    device: FakeDevice, make: Made
) -> None:
    device.ai_simultaneous_sampling_supported = True
    before = _configured(make())
    assert before.channels()[1].skew_s == 0.0
    before.close()
    source = make(skew={"ub": Quantity(3.0, "us")})
    source.select(("gyro",), ("ua", "ub"))
    assert source.configure(1e-4).offsets_s == pytest.approx((0.0, 0.0, 3e-6))


def test_inputs_are_set_up_as_the_station_says(device: FakeDevice, make: Made) -> None:
    _configured(
        make(
            range=Quantity(5.0, "V"),
            ranges={"ua": Quantity(800.0, "mV")},
            wiring=Wiring.DIFFERENTIAL,
            coupling=Coupling.DC,
        ),
        1e-4,
    )
    (task,) = device.tasks
    assert [(one.physical, one.name, one.ai_rng_high) for one in task.ai_channels.made] == [
        ("Dev1/ai0", "gyro", 5.0),
        ("Dev1/ai1", "ua", 1.0),
        ("Dev1/ai2", "ub", 5.0),
    ]
    assert {one.terminal_config.name for one in task.ai_channels.made} == {"DIFF"}
    assert {one.ai_coupling.name for one in task.ai_channels.made} == {"DC"}
    assert task.timing.sample_mode.name == "CONTINUOUS"
    assert task.timing.samps_per_chan == 100_000
    assert task.triggers.start_trigger.source is None


def test_every_sample_has_its_place_and_its_value(device: FakeDevice, make: Made) -> None:
    clock = VirtualClock()
    source = _configured(make(keys={"clock": clock}))
    for _ in range(2):
        source.start(0, 2500)
        blocks = _all(source)
        assert [(one.first, len(one.flags)) for one in blocks] == [(0, 1000), (1000, 1000), (2000, 500)]
        values = np.concatenate([one.values for one in blocks])
        np.testing.assert_allclose(values, 1e-4 * np.arange(2500)[:, None] + np.arange(3))
        assert not any(one.flags.any() for one in blocks)
        assert blocks[1].time_s[0] == pytest.approx(1.0)
    assert clock.now_s() == pytest.approx(5.0)
    assert device.tasks[0].starts == 2
    assert source.remarks() == ()


def test_a_short_read_is_taken_as_it_is_laid_out(device: FakeDevice, make: Made) -> None:
    source = _configured(make())
    device.available = [300]
    source.start(0, 2000)
    blocks = _all(source)
    assert len(blocks[0].flags) == 300
    values = np.concatenate([one.values for one in blocks])
    np.testing.assert_allclose(values, 1e-4 * np.arange(2000)[:, None] + np.arange(3))


def test_nothing_at_all_is_an_error(device: FakeDevice, make: Made) -> None:
    source = _configured(make(keys={"io_timeout_s": 2.0}))
    device.available = [0]
    source.start(0, 2000)
    with pytest.raises(InstrumentTimeoutError, match="no sample has arrived for 2 s"):
        source.fetch()


def test_a_clipped_output_is_an_overload_and_a_clipped_encoder_a_fault(
    device: FakeDevice, make: Made
) -> None:
    def clipped(first: int, count: int, channel: int) -> Any:
        values = np.zeros(count)
        values[3 + channel] = (-1.0) ** channel * 10.0
        return values

    device.signal = clipped
    source = _configured(make())
    source.start(0, 100)
    (block,) = _all(source)
    assert block.flags[3] == SampleFlag.OVERLOAD
    assert block.flags[4] == block.flags[5] == SampleFlag.FAULT
    assert np.count_nonzero(block.flags) == 3
    assert source.remarks() == (
        "Dev1 (PCIe-6343): 'ua' is clipped in 1 sample",
        "Dev1 (PCIe-6343): 'ub' is clipped in 1 sample",
    )


@pytest.mark.parametrize("code", [-200279, -200222, -200361])
def test_an_overrun_is_told_and_the_acquisition_goes_on(
    device: FakeDevice, make: Made, code: int
) -> None:
    source = _configured(make())
    device.fail_at = {1500: code}
    source.start(0, 5000)
    assert source.fetch() is not None
    with pytest.raises(InstrumentError, match=rf"not able to keep up \(NI-DAQmx {code}\); "):
        source.fetch()
    first = source.recover()
    assert first == 2100
    source.start(first, 5000)
    blocks = _all(source)
    assert blocks[0].first == first
    assert blocks[-1].first + len(blocks[-1].flags) == 5000
    assert "1 overrun" in source.remarks()[0]
    assert "started anew 1 time" in source.remarks()[1]


def test_an_external_trigger_is_waited_for_once(device: FakeDevice, make: Made) -> None:
    source = _configured(make(trigger=Trigger.EXTERNAL, trigger_terminal="PFI1"))
    assert device.tasks[-1].triggers.start_trigger.source == "/Dev1/PFI1"
    device.available = [0, 0, 40]
    source.start(0, 1000)
    assert sum(len(one.flags) for one in _all(source)) == 1000
    first = source.recover()
    source.start(first, first + 10)
    assert device.tasks[-1].triggers.start_trigger.source is None
    source.start(0, 10)
    assert device.tasks[-1].triggers.start_trigger.source == "/Dev1/PFI1"


def test_no_trigger_in_time_is_an_error(device: FakeDevice, make: Made) -> None:
    source = _configured(make(trigger=Trigger.EXTERNAL, trigger_timeout=Quantity(2.0, "s")))
    device.available = [0] * 4
    source.start(0, 1000)
    with pytest.raises(InstrumentTimeoutError, match="no trigger at PFI0 within 2 s"):
        source.fetch()
    assert source.recover() == 0


def test_a_rate_that_the_device_does_not_have_is_refused(device: FakeDevice, make: Made) -> None:
    source = make()
    with pytest.raises(InstrumentError, match=r"samples at 3000\.03 Hz where 3000 Hz is asked for"):
        source.configure(1.0 / 3000.0)


@pytest.mark.parametrize(
    ("resource", "settings", "told"),
    [
        (
            "Dev2",
            {},
            "Dev2: asking who is there: Device identifier is invalid (NI-DAQmx -200220); is the",
        ),
        (
            "Dev1",
            {"terminals": {"gyro": "ai9"}},
            "no input 'ai9', which terminals names for 'gyro'; it has",
        ),
        ("Dev1", {"range": Quantity(42.0, "V")}, "(NI-DAQmx -200077); a value is beyond"),
    ],
)
def test_what_the_device_does_not_have_is_told(
    device: FakeDevice, make: Made, resource: str, settings: dict[str, Any], told: str
) -> None:
    with pytest.raises(InstrumentError, match=re.escape(told)):
        _configured(make(resource, **settings))


def test_a_device_that_is_in_use_is_told(device: FakeDevice, make: Made) -> None:
    _configured(make())
    with pytest.raises(InstrumentError, match="another program uses the device"):
        _configured(make())


def test_another_serial_number_is_refused(device: FakeDevice, make: Made) -> None:
    make(keys={"serial_number": "01a2b3c4"})
    with pytest.raises(InstrumentIdentityError, match="found serial number 01A2B3C4, expected 1234"):
        make(keys={"serial_number": "1234"})
    source = _configured(make())
    device.serial_num = 5
    with pytest.raises(InstrumentIdentityError, match="found serial number 00000005"):
        source.recover()


def test_closing_frees_the_device(device: FakeDevice, make: Made) -> None:
    source = _configured(make())
    source.start(0, 100)
    source.close()
    source.close()
    assert all(one.closed for one in device.tasks)


def test_without_nis_driver_it_says_what_to_install(device: FakeDevice, make: Made) -> None:
    device.driver = False
    with pytest.raises(InstrumentError, match=r"NI-DAQmx is not on this computer.*ni\.com/downloads"):
        make()


def test_without_the_package_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, make: Made
) -> None:
    monkeypatch.setitem(sys.modules, "nidaqmx", None)
    with pytest.raises(InstrumentError, match=r"^Dev1: .*pip install 'gyrotest\[ni\]'"):
        make()


def test_the_package_is_imported_only_when_the_driver_opens() -> None:
    code = "import sys, gyrotest.instruments.ni_daqmx; print('nidaqmx' in sys.modules)"
    said = subprocess.run((sys.executable, "-c", code), capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "False"


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"terminals": {}}, "terminals is empty"),
        ({"terminals": {"gyro": "Dev1/ai0"}}, "'Dev1/ai0' is no terminal"),
        ({"terminals": {"gyro": "ai0", "ua": "ai0"}}, "names one of them twice"),
        ({"range": Quantity(0.0, "V")}, "range 0 V of 'range' is not more than zero"),
        ({"ranges": {"ux": Quantity(1.0, "V")}}, "'ux' is none of the terminals' names: gyro, ua, ub"),
    ],
)
def test_settings_that_cannot_be_are_refused(settings: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        NiDaqmxSettings(**({"terminals": _TERMINALS} | settings))


def test_the_fake_has_the_names_of_the_real_package() -> None:
    """Runs where the package is installed; its driver is not needed for that."""
    pytest.importorskip("nidaqmx", exc_type=ImportError)
    from nidaqmx import constants, errors, stream_readers, system
    from nidaqmx.task import Task

    for name in ("Error", "DaqError", "DaqReadError", "DaqNotFoundError", "DaqNotSupportedError"):
        fake, real = getattr(fake_nidaqmx, name), getattr(errors, name)
        assert [one.__name__ for one in fake.__mro__] == [one.__name__ for one in real.__mro__]
    for kind in ("TerminalConfiguration", "AcquisitionType", "Coupling", "Edge"):
        for member in getattr(fake_nidaqmx, kind):
            assert getattr(constants, kind)[member.name].value == member.value
    for name in ("product_type", "serial_num", "is_simulated", "ai_physical_chans"):
        assert isinstance(getattr(system.Device, name), property)
    assert isinstance(system.Device.ai_simultaneous_sampling_supported, property)
    reader = stream_readers.AnalogMultiChannelReader
    assert _parameters(reader.read_many_sample) == _parameters(
        fake_nidaqmx.AnalogMultiChannelReader.read_many_sample
    )
    assert {"start", "stop", "close", "ai_channels", "timing", "triggers", "in_stream"} <= set(dir(Task))


def _parameters(function: Any) -> list[str]:
    return list(inspect.signature(function).parameters)
