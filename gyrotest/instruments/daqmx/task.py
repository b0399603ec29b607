"""A task of NI-DAQmx: analogue inputs that the device's own clock takes, read in blocks."""

import contextlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.instruments.daqmx.library import NOT_YET, Library
from gyrotest.instruments.ni_daqmx_settings import NiDaqmxSettings, Wiring
from gyrotest.instruments.synchronous.settings import Trigger

# What the computer keeps while it is not asked for.
_BUFFER_S = 10.0
_LEAST_BUFFER = 10_000
_WIRINGS = {
    Wiring.DEFAULT: "DEFAULT",
    Wiring.DIFFERENTIAL: "DIFF",
    Wiring.PSEUDODIFFERENTIAL: "PSEUDO_DIFF",
    Wiring.RSE: "RSE",
    Wiring.NRSE: "NRSE",
}


class InputTask:
    """The task with these channels, not started yet. Everything but `close` raises `InstrumentError`."""

    def __init__(
        self,
        library: Library,
        who: str,
        device: str,
        *,
        channels: Sequence[str],
        settings: NiDaqmxSettings,
        rate_hz: float,
        trigger: Trigger,
    ) -> None:
        self._library, self._who = library, who
        self.trigger = trigger
        self._channels: list[Any] = []
        with library.told(who, "setting the inputs up"):
            self._task: Any = library.nidaqmx.Task()
        try:
            with library.told(who, "setting the inputs up"):
                for name in channels:
                    self._add(device, name, settings)
                self._time(device, settings, rate_hz)
                self.rate_hz = float(self._task.timing.samp_clk_rate)
                self.full_scales_v = np.array([float(one.ai_rng_high) for one in self._channels])
            self._reader = library.readers.AnalogMultiChannelReader(self._task.in_stream)
        except BaseException:
            self.close()
            raise

    def convert_interval_s(self) -> float:
        """Time between the conversions of two channels, of a device with one converter for all."""
        with self._library.told(self._who, "reading the converter's rate"):
            return 1.0 / float(self._task.timing.ai_conv_rate)

    def start(self) -> None:
        """Begin, or wait for the trigger."""
        with self._library.told(self._who, "starting"):
            self._task.start()

    def stop(self) -> None:
        """End; it can be started again."""
        with self._library.told(self._who, "stopping"):
            self._task.stop()

    def read(self, samples: int, timeout_s: float) -> NDArray[np.float64]:
        """The next samples (n, channels), V; fewer, or none, where no more come in time."""
        data = np.empty((len(self._channels), samples))
        with self._library.told(self._who, "reading"):
            count = self._read(data, samples, timeout_s)
        # Of a short read each channel's samples follow those of the one before without a space.
        channels = len(data)
        return np.ascontiguousarray(data.reshape(-1)[: channels * count].reshape(channels, count).T)

    def close(self) -> None:
        """Free the device; never raises."""
        with contextlib.suppress(Exception):
            self._task.close()

    def _read(self, data: NDArray[np.float64], samples: int, timeout_s: float) -> int:
        try:
            return int(self._reader.read_many_sample(data, samples, timeout_s))
        except self._library.errors.DaqReadError as error:
            if error.error_code != NOT_YET:
                raise
            return int(error.samps_per_chan_read)

    def _add(self, device: str, name: str, settings: NiDaqmxSettings) -> None:
        constants, range_v = self._library.constants, settings.range_v(name)
        channel = self._task.ai_channels.add_ai_voltage_chan(
            f"{device}/{settings.terminals[name]}",
            name_to_assign_to_channel=name,
            terminal_config=constants.TerminalConfiguration[_WIRINGS[settings.wiring]],
            min_val=-range_v,
            max_val=range_v,
        )
        if settings.coupling is not None:
            channel.ai_coupling = constants.Coupling[settings.coupling.name]
        self._channels.append(channel)

    def _time(self, device: str, settings: NiDaqmxSettings, rate_hz: float) -> None:
        self._task.timing.cfg_samp_clk_timing(
            rate_hz,
            sample_mode=self._library.constants.AcquisitionType.CONTINUOUS,
            samps_per_chan=max(_LEAST_BUFFER, round(_BUFFER_S * rate_hz)),
        )
        if self.trigger is Trigger.EXTERNAL:
            self._task.triggers.start_trigger.cfg_dig_edge_start_trig(
                f"/{device}/{settings.trigger_terminal}"
            )
