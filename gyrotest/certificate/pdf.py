"""The certificate as PDF/A-3u, drawn from a run record and from nothing else."""

import ctypes
import os
import re
import sys
import warnings
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrotest.certificate.csv import results_csv
from gyrotest.certificate.record import record_bytes, record_sha256
from gyrotest.certificate.view import view
from gyrotest.errors import CertificateError, RefusedError
from gyrotest.records.run import RunRecord

if TYPE_CHECKING:
    import weasyprint

RECORD_NAME = "run.json"
RESULTS_NAME = "results.csv"
_FONTS = (("Inter-Regular.ttf", 400), ("Inter-SemiBold.ttf", 600))
_FACES = "".join(
    f"@font-face{{font-family:Inter;font-weight:{weight};src:url(font:{name})}}"
    for name, weight in _FONTS
)
_APART = ".annex{break-before:page}"  # a certificate that would fit one page is set on two
_LIBRARIES = ("gobject-2.0", "pango-1.0", "harfbuzz", "fontconfig", "pangoft2-1.0")
_UNSAFE = re.compile(r"[^A-Za-z0-9.-]+")
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f\ufffe\uffff\ud800-\udfff]")
_INSTALL = {
    "linux": "Debian or Ubuntu: apt-get install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0; "
    "Fedora: dnf install pango",
    "darwin": "brew install pango",
    "win32": "install MSYS2, then in its shell: pacman -S mingw-w64-ucrt-x86_64-pango",
}


def ensure_renderer() -> None:
    """Find the libraries that a certificate needs; raises `RefusedError` saying what to install."""
    if sys.platform == "linux" and all(
        _loads(f"lib{name}.so.0", f"lib{name}.so.1") for name in _LIBRARIES
    ):
        return
    try:
        _weasyprint()
    except (OSError, ImportError) as error:
        system = "linux" if sys.platform not in _INSTALL else sys.platform
        raise RefusedError(
            f"no certificate could be written: Pango is missing ({error}); {_INSTALL[system]}"
        ) from error


def write_certificate(record: RunRecord, folder: Path) -> Path:
    """Write the certificate into a folder, never over another file; raises `CertificateError`."""
    try:
        content = certificate_bytes(record)
    except OSError as error:
        raise CertificateError(f"{folder}: the certificate cannot be drawn: {error}") from error
    begin = f"{record.header.started_utc:%Y%m%dT%H%M%SZ}"
    parts = (record.serial_number, record.model, begin, record.verdict.value)
    name = "_".join(_UNSAFE.sub("-", part)[:64].strip("-") or "-" for part in parts)
    aside = folder / f".{name}.{os.getpid()}.part"
    try:
        aside.write_bytes(content)
        return _settle(aside, folder, name)
    except OSError as error:
        raise CertificateError(f"{folder}: the certificate cannot be written: {error}") from error
    finally:
        aside.unlink(missing_ok=True)


def certificate_bytes(record: RunRecord, data: bytes | None = None) -> bytes:
    """Draw the certificate; the same record gives the same bytes.

    `data` is the record as JSON where it exists already, and is then attached as it is.
    """
    data = record_bytes(record) if data is None else data
    digest = record_sha256(data)
    attachments = (
        _attachment(RECORD_NAME, data, "Source", record),
        _attachment(RESULTS_NAME, results_csv(record).encode(), "Data", record),
    )
    return _typeset(
        _html(record, digest), identifier=bytes.fromhex(digest[:32]), attachments=attachments
    )


def _settle(aside: Path, folder: Path, name: str) -> Path:
    """Give the file its name, or the first free one after it, without ever replacing another."""
    for number in range(1, 1000):
        target = folder / (f"{name}.pdf" if number == 1 else f"{name}-{number}.pdf")
        with suppress(FileExistsError):
            target.touch(exist_ok=False)
            aside.replace(target)
            return target
    raise CertificateError(f"{folder / name}.pdf: 999 certificates of this name exist already")


def _html(record: RunRecord, digest: str) -> str:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(_template),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    shown = view(printable(record), digest)
    return environment.get_template("certificate.html.j2").render(view=shown)


def printable(value: Any) -> Any:
    """Replace characters that cannot be printed in all texts of a record."""
    if isinstance(value, str):
        return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", value) if type(value) is str else value
    if isinstance(value, tuple):
        return value if value and isinstance(value[0], float) else tuple(printable(one) for one in value)
    if isinstance(value, dict):
        return {printable(key): printable(one) for key, one in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        changed = {one.name: printable(getattr(value, one.name)) for one in fields(value)}
        return type(value)(**changed)
    return value


def _template(name: str) -> str:
    return (resources.files("gyrotest.certificate") / "templates" / name).read_text(encoding="utf-8")


def _typeset(html: str, *, identifier: bytes, attachments: tuple[Any, ...] = ()) -> bytes:
    """Make a PDF of a page that may load nothing from outside."""
    weasyprint = _weasyprint()
    from weasyprint.text.fonts import FontConfiguration
    from weasyprint.urls import FatalURLFetchingError, URLFetcher

    fetcher = URLFetcher(allowed_protocols=["data"], fail_on_errors=True)
    fonts = FontConfiguration()
    faces = weasyprint.CSS(string=_FACES, font_config=fonts, url_fetcher=_bundled_font)
    page = weasyprint.HTML(string=html, url_fetcher=fetcher, base_url="https://certificate.invalid/")
    options = {"pdf_variant": "pdf/a-3u", "pdf_identifier": identifier, "attachments": list(attachments)}
    try:
        with warnings.catch_warnings():
            # It leaves the file of its colour profile for the interpreter to close.
            warnings.simplefilter("ignore", ResourceWarning)
            document = page.render(font_config=fonts, stylesheets=[faces], **options)
            if len(document.pages) < 2:
                apart = weasyprint.CSS(string=_APART, font_config=fonts, url_fetcher=fetcher)
                document = page.render(font_config=fonts, stylesheets=[faces, apart], **options)
            content: bytes = document.write_pdf(**options)
    except FatalURLFetchingError as error:
        raise CertificateError(f"the certificate refers to something outside itself: {error}") from error
    return content


def _bundled_font(url: str) -> Any:
    """Answer the certificate's own style sheet of fonts, which asks for nothing else."""
    from weasyprint.urls import URLFetcherResponse

    name = url.removeprefix("font:")
    content = (resources.files("gyrotest.certificate") / "fonts" / name).read_bytes()
    return URLFetcherResponse(url, content, {"Content-Type": "font/ttf"})


def _attachment(name: str, data: bytes, relationship: str, record: RunRecord) -> Any:
    return _weasyprint().Attachment(
        string=data,
        name=name,
        relationship=relationship,
        created=record.issued_utc,
        modified=record.issued_utc,
    )


def _weasyprint() -> "weasyprint":
    with warnings.catch_warnings():
        # It announces libraries that it will need some day.
        warnings.simplefilter("ignore", DeprecationWarning)
        import weasyprint

    return weasyprint


def _loads(*names: str) -> bool:
    for name in names:
        with suppress(OSError):
            ctypes.CDLL(name)
            return True
    return False
