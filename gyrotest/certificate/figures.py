"""Figures drawn by matplotlib: the same for a certificate's pages and for files of their own."""

import io
from typing import TYPE_CHECKING, Literal

from gyrotest.certificate.style import styled
from gyrotest.records.figure import Figure

if TYPE_CHECKING:
    import matplotlib.figure

Format = Literal["svg", "pdf", "png"]

_UNDATED: dict[Format, dict[str, None]] = {
    "svg": dict.fromkeys(("Creator", "Date", "Format", "Type")),
    "pdf": dict.fromkeys(("Creator", "Producer", "CreationDate")),
    "png": {"Software": None},
}
_PNG_DPI = 200


def draw(figure: Figure) -> "matplotlib.figure.Figure":
    """Draw a figure; its size is in points, as on a certificate."""
    with styled():
        from gyrotest.certificate.drawing import drawing

        return drawing(figure)


def image(figure: Figure, form: Format) -> bytes:
    """Return a figure as a file's content; the same figure gives the same bytes."""
    file = io.BytesIO()
    with styled():
        # How text is written is asked for only now.
        draw(figure).savefig(
            file,
            format=form,
            metadata=_UNDATED[form],
            dpi=_PNG_DPI,
            facecolor="none" if form == "svg" else "white",
        )
    return file.getvalue()


def svg(figure: Figure) -> str:
    """Return a figure as SVG."""
    return image(figure, "svg").decode()
