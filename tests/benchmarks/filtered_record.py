"""What a low-pass filter and a spectral line do to the angle random walk of a real gyro at rest.

`python -m tests.benchmarks.filtered_record gyro_lsb.npz` draws docs/images/filtered-record.png and
prints the table of docs/noise.md. The recording is the one of an ADIS16405 of SMAC-Group/imudata
(1,000,000 samples of three axes, 100 Hz, CC BY-NC-SA 4.0), which is not part of the project.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.allan import AllanDeviation, overlapping_allan_deviation
from gyrotest.analysis.noise import NoiseModel, identify_noise
from gyrotest.analysis.spectral_lines import spectrum
from gyrotest.certificate.figures import image
from gyrotest.records.figure import Curve, Figure, Mark, Panel, Role, Scale

RATE_HZ = 100.0
SHOWN_S = 26.0
ROOT_HOUR = 60.0  # °/√h in a °/√s
WHITE_HZ = (1.0, 5.0)  # above flicker noise, below the filter and the line
PICTURE = Path("docs/images/filtered-record.png")


@dataclass(frozen=True, kw_only=True)
class Axis:
    """One axis, and its readings of the angle random walk, °/√h, at all averaging times (k,)."""

    name: str
    curve: AllanDeviation
    model: NoiseModel
    from_spectrum: float

    @property
    def readings(self) -> NDArray[np.float64]:
        return self.curve.deviation_dps * np.sqrt(self.curve.tau_s) * ROOT_HOUR

    def reading(self, tau_s: float) -> float:
        return float(self.readings[np.argmin(np.abs(self.curve.tau_s - tau_s))])

    @property
    def straight_line(self) -> float:
        """Of a line of slope −1/2 through the first decade."""
        return float(np.exp(np.log(self.readings[self.curve.tau_s < 0.105]).mean()))


def axes(path: Path) -> Iterator[Axis]:
    archive = np.load(path)
    for name, counts in zip("xyz", archive["gyro_lsb"].T, strict=True):
        rate = counts * float(archive["lsb_dps"])
        curve = overlapping_allan_deviation(rate, sample_rate_hz=RATE_HZ)
        model = identify_noise(rate, sample_rate_hz=RATE_HZ, deviation=curve)
        yield Axis(name=name, curve=curve, model=model, from_spectrum=_from_spectrum(rate, model))


def _from_spectrum(rate: NDArray[np.float64], model: NoiseModel) -> float:
    found = spectrum(rate, sample_rate_hz=RATE_HZ)
    assert found is not None
    band = (found.frequency_hz >= WHITE_HZ[0]) & (found.frequency_hz <= WHITE_HZ[1])
    flicker = model.bias_instability_coefficient.value**2 / (np.pi * found.frequency_hz[band])
    return ROOT_HOUR * float(np.sqrt(np.mean(found.density[band] - flicker) / 2.0))


def table(found: Sequence[Axis]) -> Iterator[str]:
    yield (
        "| axis | at τ = 0.01 s | line through 0.01 … 0.1 s | highest below 0.1 s | at 1 s"
        " | identified N, 95 % interval | spectrum at 1 … 5 Hz |"
    )
    yield "|---|---|---|---|---|---|---|"
    for one in found:
        walk = one.model.angle_random_walk
        cells = [one.reading(0.01), one.straight_line, one.readings[one.curve.tau_s < 0.095].max()]
        cells.append(one.reading(1.0))
        lower, upper = walk.lower_95 * ROOT_HOUR, walk.upper_95 * ROOT_HOUR
        yield (
            f"| {one.name} | {' | '.join(f'{cell:.2f}' for cell in cells)}"
            f" | **{walk.value * ROOT_HOUR:.3f}** ({lower:.3f} … {upper:.3f}) | {one.from_spectrum:.2f} |"
        )


def picture(found: Sequence[Axis]) -> Figure:
    return Figure(
        name="filtered_record",
        title="Readings of the angle random walk",
        panels=tuple(_panel(one) for one in found),
    )


def _panel(axis: Axis) -> Panel:
    shown = axis.curve.tau_s <= SHOWN_S
    tau_s = axis.curve.tau_s[shown]
    fitted = tau_s >= axis.model.first_tau_s * (1 - 1e-9)
    model = axis.model.allan_deviation_dps(axis.curve.averaging_factor[shown][fitted])
    walk = axis.model.angle_random_walk.value * ROOT_HOUR
    return Panel(
        y_label="σ·√τ / (°/√h)",
        x_label="Averaging time τ / s",
        x_scale=Scale.LOG,
        height=1.35,
        curves=(
            Curve(x=tuple(tau_s), y=tuple(axis.readings[shown])),
            Curve(
                x=tuple(tau_s[fitted]),
                y=tuple(model * np.sqrt(tau_s[fitted]) * ROOT_HOUR),
                role=Role.MODEL,
                label="fit",
            ),
            Curve(
                x=(float(tau_s[0]), float(tau_s[-1])),
                y=(walk, walk),
                role=Role.COMPONENT,
                label=f"N = {walk:.3f} °/√h",
            ),
        ),
        marks=tuple(_marks(axis)),
        note=f"{axis.name} axis",
    )


def _marks(axis: Axis) -> Iterator[Mark]:
    yield Mark(x=0.01, y=axis.reading(0.01), label=f"shortest τ: {axis.reading(0.01):.2f}")
    short = np.flatnonzero(axis.curve.tau_s < 0.095)
    highest = int(short[np.argmax(axis.readings[short])])
    if axis.readings[highest] > 1.1 * axis.reading(1.0):
        value, tau_s = float(axis.readings[highest]), float(axis.curve.tau_s[highest])
        yield Mark(x=tau_s, y=value, label=f"the line's hump: {value:.2f}")
    yield Mark(x=1.0, y=axis.reading(1.0), label=f"1 s: {axis.reading(1.0):.2f}")


def remarks(found: Sequence[Axis]) -> Iterator[str]:
    for one in found:
        lines = [
            f"{line.frequency_hz:.2f} Hz, {line.amplitude_dps:.4f} °/s peak" for line in one.model.lines
        ]
        yield (
            f"{one.name}: from τ = {one.model.first_tau_s:g} s, χ²/ν = {one.model.misfit:.2f}, by chance"
            f" {100 * one.model.fit_probability:.0f} %; {'; '.join(lines) or 'no line'}"
        )


def main(path: Path) -> None:
    found = list(axes(path))
    PICTURE.write_bytes(image(picture([found[0], found[2]]), "png"))
    sys.stdout.write("\n".join((*table(found), *remarks(found), "")))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
