"""A stand-in for NI's Python package, with the documented names that the driver uses and no others.

`FakeDevice` is the device behind it; `install` puts the modules where they are imported from.
"""

import enum
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest


class Error(Exception):
    pass


class DaqNotFoundError(Error):
    pass


class DaqNotSupportedError(Error):
    pass


class DaqError(Error):
    def __init__(self, message: str, error_code: int, task_name: str = "") -> None:
        super().__init__(message)
        self.error_code = error_code


class DaqReadError(DaqError):
    def __init__(
        self, message: str, error_code: int, samps_per_chan_read: int, task_name: str = ""
    ) -> None:
        super().__init__(message, error_code, task_name)
        self.samps_per_chan_read = samps_per_chan_read


TerminalConfiguration = enum.Enum(
    "TerminalConfiguration",
    {"RSE": 10083, "NRSE": 10078, "DIFF": 10106, "PSEUDO_DIFF": 12529, "DEFAULT": -1},
)
AcquisitionType = enum.Enum("AcquisitionType", {"FINITE": 10178, "CONTINUOUS": 10123})
Coupling = enum.Enum("Coupling", {"AC": 10045, "DC": 10050, "GND": 10066})
Edge = enum.Enum("Edge", {"RISING": 10280, "FALLING": 10171})
VoltageUnits = enum.Enum("VoltageUnits", {"VOLTS": 10348})


def ramp(first: int, count: int, channel: int) -> Any:
    """Samples that say which ones they are."""
    return 1e-4 * np.arange(first, first + count) + channel


@dataclass
class FakeDevice:
    """The device, and what goes wrong with it.

    `signal(first, count, channel)` are the volts. `available` limits what each read gets, one entry a
    read; then everything comes. `fail_at` raises a status code once, at the first read that reaches this sample.
    """

    name: str = "Dev1"
    product_type: str = "PCIe-6343"
    serial_num: int = 0x01A2B3C4
    is_simulated: bool = False
    ai_simultaneous_sampling_supported: bool = False
    inputs: tuple[str, ...] = ("ai0", "ai1", "ai2", "ai3")
    conv_rate_hz: float = 100_000.0
    timebase_hz: float = 100e6
    widest_v: float = 10.0
    driver: bool = True
    signal: Callable[[int, int, int], Any] = ramp
    available: list[int] = field(default_factory=list)
    fail_at: dict[int, int] = field(default_factory=dict)
    tasks: list["Task"] = field(default_factory=list)

    @property
    def ai_physical_chans(self) -> list[Any]:
        return [SimpleNamespace(name=f"{self.name}/{one}") for one in self.inputs]


_PRESENT: list[FakeDevice] = []


def Device(name: str) -> FakeDevice:  # noqa: N802 - a class of the library
    (device,) = _PRESENT
    if not device.driver:
        raise DaqNotFoundError("Could not find an installation of NI-DAQmx.\nInstall it.")
    if name != device.name:
        raise DaqError("Device identifier is invalid.\n\nStatus Code: -200220", -200220)
    return device


@dataclass
class Channel:
    physical: str
    name: str
    terminal_config: Any
    ai_rng_high: float
    ai_coupling: Any = None


class Channels:
    def __init__(self, task: "Task") -> None:
        self._task = task
        self.made: list[Channel] = []

    def add_ai_voltage_chan(
        self,
        physical_channel: str,
        name_to_assign_to_channel: str = "",
        terminal_config: Any = TerminalConfiguration.DEFAULT,
        min_val: float = -5.0,
        max_val: float = 5.0,
        units: Any = VoltageUnits.VOLTS,
        custom_scale_name: str = "",
    ) -> Channel:
        ranges = (0.1, 1.0, 5.0, 10.0)
        if max_val > self._task.device.widest_v or min_val != -max_val:
            raise DaqError("Requested value is not a supported value.\n\nProperty: AI.Max", -200077)
        wider = min(one for one in ranges if one >= max_val)
        self.made.append(Channel(physical_channel, name_to_assign_to_channel, terminal_config, wider))
        return self.made[-1]


class Timing:
    def __init__(self, device: FakeDevice) -> None:
        self._device = device

    def cfg_samp_clk_timing(
        self,
        rate: float,
        source: str = "",
        active_edge: Any = Edge.RISING,
        sample_mode: Any = AcquisitionType.FINITE,
        samps_per_chan: int = 1000,
    ) -> None:
        timebase_hz = self._device.timebase_hz
        self.samp_clk_rate = timebase_hz / round(timebase_hz / rate)
        self.sample_mode, self.samps_per_chan = sample_mode, samps_per_chan

    @property
    def ai_conv_rate(self) -> float:
        if self._device.ai_simultaneous_sampling_supported:
            raise DaqError("Specified property is not supported by the device.", -200197)
        return self._device.conv_rate_hz


class StartTrigger:
    source: str | None = None

    def cfg_dig_edge_start_trig(self, trigger_source: str, trigger_edge: Any = Edge.RISING) -> None:
        self.source = trigger_source


class Task:
    def __init__(self, new_task_name: str = "") -> None:
        (self.device,) = _PRESENT
        if any(not one.closed for one in self.device.tasks):
            raise DaqError("The specified resource is reserved.", -50103)
        self.device.tasks.append(self)
        self.ai_channels = Channels(self)
        self.timing = Timing(self.device)
        self.triggers = SimpleNamespace(start_trigger=StartTrigger())
        self.in_stream = SimpleNamespace(task=self)
        self.closed = self.running = False
        self.starts = self.position = 0

    def start(self) -> None:
        assert not self.running
        self.running, self.position = True, 0
        self.starts += 1

    def stop(self) -> None:
        self.running = False

    def close(self) -> None:
        self.closed, self.running = True, False


class AnalogMultiChannelReader:
    def __init__(self, task_in_stream: Any) -> None:
        self._task: Task = task_in_stream.task

    def read_many_sample(
        self, data: Any, number_of_samples_per_channel: int = -1, timeout: float = 10.0
    ) -> int:
        task, device, wanted = self._task, self._task.device, number_of_samples_per_channel
        assert task.running
        assert data.flags.c_contiguous
        assert data.shape == (len(task.ai_channels.made), wanted)
        for at, code in tuple(device.fail_at.items()):
            if task.position + wanted > at:
                del device.fail_at[at]
                task.running = False
                raise DaqReadError("The application is not able to keep up.\n\nMore.", code, 0)
        count = min(wanted, device.available.pop(0)) if device.available else wanted
        rows = [device.signal(task.position, count, at) for at in range(len(data))]
        data.reshape(-1)[: count * len(rows)] = np.concatenate(rows)
        task.position += count
        if count < wanted:
            raise DaqReadError("Some or all of the samples are not yet available.", -200284, count)
        return count


def install(monkeypatch: pytest.MonkeyPatch, device: FakeDevice) -> FakeDevice:
    """Let `nidaqmx` be this, with one device."""
    errors = (Error, DaqError, DaqReadError, DaqNotFoundError, DaqNotSupportedError)
    constants = {
        "TerminalConfiguration": TerminalConfiguration,
        "AcquisitionType": AcquisitionType,
        "Coupling": Coupling,
        "Edge": Edge,
    }
    parts: dict[str, dict[str, Any]] = {
        "nidaqmx": {"Task": Task},
        "nidaqmx.constants": constants,
        "nidaqmx.errors": {one.__name__: one for one in errors},
        "nidaqmx.stream_readers": {"AnalogMultiChannelReader": AnalogMultiChannelReader},
        "nidaqmx.system": {"Device": Device},
    }
    for name, content in parts.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(f"{__name__}._PRESENT", [device])
    return device
