"""The options of `gyrotest analyse` as one checked record; all their faults at once."""

import argparse
import difflib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, cast

from gyrotest.errors import GyrotestError, RecordingError, SpecError, UnitError
from gyrotest.offline.request import Request, Window, canonical_unit
from gyrotest.records.spec import Gaps, OutputKind, SpecDocument
from gyrotest.units import Dimension, Quantity, conversion_factor, parse_quantity, same_dimension

if TYPE_CHECKING:
    from collections.abc import Mapping

_PLOTS = ("pdf", "png", "svg")
_SHORTEST_S, _LONGEST_S = 1e-9, 1e6  # between samples
_UNIT_EXAMPLES = ("deg/s", "deg/h", "rad/s", "mrad/s", "V", "mV", "uV", "count", "rpm")


class FaultyOptionsError(GyrotestError):
    """The options are refused; carries all their faults."""

    def __init__(self, faults: list[str]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(faults))


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What is asked for: of the files, and where it goes (`-`: standard output)."""

    request: Request
    spec: SpecDocument | None
    json: str | None
    csv: str | None
    plot: Path | None

    @property
    def plot_format(self) -> Literal["pdf", "png", "svg"]:
        """The plot's format, by its file's ending."""
        suffix = "" if self.plot is None else self.plot.suffix.lower().removeprefix(".")
        return cast('Literal["pdf", "png", "svg"]', suffix)


def wanted(parsed: argparse.Namespace) -> Wanted:
    """Check the options; raises `FaultyOptionsError`."""
    return _Door(parsed).wanted()


class _Door:
    """Reads option after option and gathers what is wrong."""

    def __init__(self, parsed: argparse.Namespace) -> None:
        self._parsed = parsed
        self._faults: list[str] = []

    def wanted(self) -> Wanted:
        parsed = self._parsed
        spec = self._spec()
        request = self._request(spec)
        self._check_outputs()
        if self._faults or request is None:
            raise FaultyOptionsError(self._faults)
        return Wanted(request=request, spec=spec, json=parsed.json, csv=parsed.csv, plot=parsed.plot)

    def _request(self, spec: SpecDocument | None) -> Request | None:
        parsed = self._parsed
        unit = self._unit(spec)
        scale_factor, zero_rate, bandwidth = self._output(spec, unit)
        interval_s, window, where = self._interval(), self._window(), self._where()
        aperture = self._positive("aperture", Dimension.TIME)
        self._check_sampling(interval_s, aperture)
        self._check_time_unit()
        if self._faults:
            return None
        return Request(
            columns=tuple(dict.fromkeys(map(_column, parsed.column or ()))),
            array=parsed.array,
            where=where,
            skip_rows=parsed.skip_rows,
            interval_s=interval_s,
            time_column=None if parsed.time_column is None else _column(parsed.time_column),
            time_unit=parsed.time_unit,
            scale=parsed.scale,
            unit=unit,
            scale_factor=scale_factor,
            zero_rate=zero_rate,
            reading_s=None if aperture is None else aperture.to("s"),
            duty=parsed.duty,
            bandwidth_hz=None if bandwidth is None else bandwidth.to("Hz"),
            window=window,
            gaps=Gaps(parsed.gaps),
            datasheet=spec.spec.datasheet if spec else {},
        )

    def _fault(self, option: str, message: str) -> None:
        self._faults.append(f"--{option}: {message}")

    def _spec(self) -> SpecDocument | None:
        if self._parsed.spec is None:
            return None
        from gyrotest.specification.lookup import find_spec
        from gyrotest.specification.spec import load_spec

        try:
            return load_spec(find_spec(self._parsed.spec, (Path("specs"),)))
        except SpecError as error:
            self._fault("spec", str(error))
            return None

    def _quantity(self, option: str, *dimensions: Dimension) -> Quantity | None:
        text = getattr(self._parsed, option.replace("-", "_"))
        if text is None:
            return None
        try:
            return parse_quantity(text, dimensions)
        except UnitError as error:
            self._fault(option, str(error))
            return None

    def _positive(self, option: str, dimension: Dimension) -> Quantity | None:
        found = self._quantity(option, dimension)
        if found is not None and found.value <= 0.0:
            self._fault(option, f"'{found}' must be more than 0")
            return None
        return found

    def _unit(self, spec: SpecDocument | None) -> str | None:
        unit: str | None = self._parsed.unit
        if unit is None:
            if spec is None:
                return None
            return "V" if spec.spec.output.kind is OutputKind.VOLTAGE else "deg/s"
        try:
            canonical_unit(unit)
        except (UnitError, RecordingError) as error:
            near = difflib.get_close_matches(unit, _UNIT_EXAMPLES, n=1, cutoff=0.5)
            hint = f"is '{near[0]}' meant?" if near else f"write e.g. {', '.join(_UNIT_EXAMPLES[:5])}"
            self._fault("unit", f"{error}; {hint}")
            return None
        return unit

    def _output(
        self, spec: SpecDocument | None, unit: str | None
    ) -> tuple[Quantity | None, Quantity | None, Quantity | None]:
        """Scale factor, zero rate and bandwidth: the options', else the spec's for the same kind."""
        scale_factor = self._quantity(
            "scale-factor",
            Dimension.SCALE_FACTOR_VOLTAGE,
            Dimension.SCALE_FACTOR_COUNT,
        )
        zero_rate = self._quantity("zero-rate", Dimension.VOLTAGE, Dimension.RATE, Dimension.COUNT)
        bandwidth = self._positive("bandwidth", Dimension.FREQUENCY)
        output = spec.spec.output if spec else None
        if output is not None and unit is not None:
            own = "V" if output.kind is OutputKind.VOLTAGE else "deg/s"
            if same_dimension(unit, own):
                scale_factor = scale_factor or output.scale_factor
                zero_rate = zero_rate or output.zero_rate
            bandwidth = bandwidth or output.bandwidth
        self._check_fit(unit, scale_factor, zero_rate)
        return scale_factor, zero_rate, bandwidth

    def _check_fit(
        self, unit: str | None, scale_factor: Quantity | None, zero_rate: Quantity | None
    ) -> None:
        if scale_factor is not None and scale_factor.value == 0.0:
            self._fault("scale-factor", "is 0")
        if unit is None:
            return
        canonical, dimension = canonical_unit(unit)
        if scale_factor is not None and not same_dimension(scale_factor.unit, dimension.value):
            self._fault(
                "scale-factor",
                f"'{scale_factor}' does not go with values in '{unit}'; "
                + ("leave it out" if dimension is Dimension.NUMBER else f"e.g. '{dimension.example()}'"),
            )
        if scale_factor is None and dimension is not Dimension.NUMBER:
            self._fault("unit", f"values in '{unit}' need --scale-factor, e.g. '{dimension.example()}'")
        if zero_rate is not None and not same_dimension(zero_rate.unit, canonical):
            self._fault("zero-rate", f"'{zero_rate}' does not go with values in '{unit}'")

    def _interval(self) -> float | None:
        rate = self._positive("rate", Dimension.FREQUENCY)
        interval = self._positive("interval", Dimension.TIME)
        if self._parsed.rate is not None and self._parsed.interval is not None:
            self._fault("interval", "give it or --rate, not both")
        if rate is not None:
            return 1.0 / rate.to("Hz")
        return None if interval is None else interval.to("s")

    def _window(self) -> Window | None:
        if self._parsed.window is None:
            return None
        try:
            begin_s, end_s = (
                parse_quantity(text, Dimension.TIME).to("s") for text in self._parsed.window
            )
        except UnitError as error:
            self._fault("window", str(error))
            return None
        if not 0.0 <= begin_s < end_s:
            self._fault("window", "must begin at 0 s or later, and before its end")
            return None
        return Window(begin_s=begin_s, end_s=end_s)

    def _where(self) -> "Mapping[str, str | int | float]":
        found: dict[str, str | int | float] = {}
        for text in self._parsed.where or ():
            name, equals, content = text.partition("=")
            if not (name and equals):
                self._fault("where", f"'{text}' is not COLUMN=CONTENT, e.g. part=z_p")
            found[name] = _content(content)
        return found

    def _check_sampling(self, interval_s: float | None, aperture: Quantity | None) -> None:
        duty = self._parsed.duty
        if duty is not None and self._parsed.aperture is not None:
            self._fault("duty", "give it or --aperture, not both")
        if duty is not None and not 0.0 < duty <= 1.0:
            self._fault("duty", f"{duty:g} is not within 0 … 1")
        if (
            aperture is not None
            and interval_s is not None
            and aperture.to("s") > interval_s * (1 + 1e-6)
        ):
            self._fault("aperture", f"'{aperture}' is longer than the interval of {interval_s:g} s")
        if self._parsed.scale == 0.0 or not math.isfinite(self._parsed.scale):
            self._fault("scale", "must be a finite number other than 0")
        if interval_s is not None and not _SHORTEST_S <= interval_s <= _LONGEST_S:
            option = "rate" if self._parsed.interval is None else "interval"
            self._fault(option, f"one sample in {interval_s:g} s is no gyro's; look at its unit")
        if self._parsed.skip_rows < 0:
            self._fault("skip-rows", "must not be below 0")

    def _check_time_unit(self) -> None:
        unit = self._parsed.time_unit
        if unit is None:
            return
        if unit == "sample":
            if self._parsed.rate is None and self._parsed.interval is None:
                self._fault("time-unit", "'sample' needs --rate or --interval")
            return
        try:
            conversion_factor(unit, "s")
        except UnitError as error:
            self._fault("time-unit", f"{error}; write e.g. s, ms, us, ns, or 'sample'")

    def _check_outputs(self) -> None:
        parsed = self._parsed
        if parsed.json == "-" and parsed.csv == "-":
            self._fault("csv", "only one of --json and --csv can go to standard output")
        if parsed.plot is not None and parsed.plot.suffix.lower().removeprefix(".") not in _PLOTS:
            self._fault("plot", f"'{parsed.plot}' must end with .pdf, .png or .svg")
        written: dict[Path, str] = {}
        for option in ("json", "csv", "plot"):
            target = getattr(parsed, option)
            if target is None or str(target) == "-":
                continue
            path = Path(target)
            if not path.parent.is_dir():
                self._fault(option, f"'{path}': there is no folder {path.parent}")
            elif any(_same_file(path, one) for one in parsed.files):
                self._fault(option, f"'{path}' is a file to be analysed; it would be overwritten")
            elif path.is_file() or not path.exists():
                other = written.setdefault(path.resolve(), option)
                if other != option:
                    self._fault(option, f"'{path}' is --{other}'s already; give another name")


def _column(text: str) -> str | int:
    return int(text) if text.isdecimal() else text


def _content(text: str) -> str | int | float:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _same_file(path: Path, other: Path) -> bool:
    try:
        return path.samefile(other)
    except OSError:
        return False
