"""A unit's share of a source: its columns by the slot's channels or by the axes' names."""

import pytest

from gyrotest.errors import InstrumentError
from gyrotest.records.recording import Auxiliary, Sampling
from gyrotest.records.station import Encoder, Slot
from gyrotest.runner.channels import share, slot_auxiliary, slot_outputs

SCANNER = Sampling(
    interval_s=1.0,
    aperture_s=0.02,
    channels=("101", "102", "103"),
    auxiliary=(Auxiliary(name="110", unit="degC"), Auxiliary(name="111", unit="degC")),
    offsets_s=(0.0, 0.04, 0.08, 0.12, 0.16),
)
TRIAD = Sampling(
    interval_s=0.008,
    aperture_s=0.008,
    unit="deg/s",
    channels=("x", "y", "z"),
    auxiliary=(Auxiliary(name="temperature_x", unit="degC"),),
)


def test_a_slot_gets_its_own_channel_and_its_own_temperature_with_their_offsets() -> None:
    slot = Slot(source="scanner", channel="102", auxiliary={"temperature": "111"})
    found = share(SCANNER, slot, (), "scanner")
    assert found.columns == (1, 4)
    assert found.sampling.columns == ("output", "temperature")
    assert found.sampling.auxiliary == (Auxiliary(name="temperature", unit="degC"),)
    assert found.sampling.offsets_s == (0.04, 0.16)


def test_each_axis_of_an_analogue_unit_may_have_a_channel() -> None:
    slot = Slot(source="scanner", channels={"x": "103", "y": "101"}, auxiliary={"t": "110"})
    found = share(SCANNER, slot, ("x", "y"), "scanner")
    assert found.columns == (2, 0, 3)
    assert found.sampling.channels == ("x", "y")
    assert slot_outputs(slot) == ("103", "101")


def test_a_digital_unit_gives_its_axes_by_name_and_all_that_is_beside_them() -> None:
    found = share(TRIAD, Slot(source="stim"), ("x", "y", "z"), "stim")
    assert found.columns == (0, 1, 2, 3)
    assert found.sampling.channels == ("x", "y", "z")


def test_one_axis_of_several_may_be_named_as_the_channel() -> None:
    found = share(TRIAD, Slot(source="stim", channel="z"), (), "stim")
    assert found.columns[0] == 2
    assert found.sampling.channels == ("output",)


def test_the_signals_of_a_slots_encoder_are_recorded_under_names_of_their_own() -> None:
    daq = Sampling(
        interval_s=1e-4,
        aperture_s=1e-4,
        channels=("gyro_x", "gyro_z"),
        auxiliary=(Auxiliary(name="ua", unit="V"), Auxiliary(name="ub", unit="V")),
        synchronous=True,
    )
    slot = Slot(source="daq", channel="gyro_z", encoder=Encoder(sine="ua", cosine="ub", lines=9000))
    found = share(daq, slot, (), "daq")
    assert found.columns == (1, 2, 3)
    assert found.sampling.columns == ("output", "encoder_sine", "encoder_cosine")
    assert slot_auxiliary(slot) == {"encoder_sine": "ua", "encoder_cosine": "ub"}


@pytest.mark.parametrize(
    ("slot", "axes", "told"),
    [
        (Slot(source="stim"), (), "gives x, y, z, and the spec's output has one axis"),
        (Slot(source="stim"), ("x", "w"), "the axes x, w; correct 'output.axes'"),
        (Slot(source="stim", channel="w"), (), "has no channel 'w'"),
        (Slot(source="stim", channels={"x": "x"}), ("x", "y"), "name none for axis y"),
        (Slot(source="stim", auxiliary={"t": "heat"}), ("x",), "has no channel heat"),
        (Slot(source="stim", encoder=Encoder(angle="theta")), ("x",), "has no channel theta"),
    ],
)
def test_a_share_that_is_not_there_is_refused(slot: Slot, axes: tuple[str, ...], told: str) -> None:
    with pytest.raises(InstrumentError, match=told):
        share(TRIAD, slot, axes, "stim")
