"""Certificates that several tests look at, each drawn once."""

import io
from collections.abc import Callable
from functools import cache

import pytest
from pypdf import PdfReader

from gyrotest.certificate.pdf import certificate_bytes
from tests.unit.certificate import bench_records, records


@cache
def _bytes(name: str) -> bytes:
    place = records if hasattr(records, name) else bench_records
    return certificate_bytes(getattr(place, name)())


@cache
def _pages(name: str) -> tuple[str, ...]:
    return tuple(page.extract_text() for page in PdfReader(io.BytesIO(_bytes(name))).pages)


@pytest.fixture
def drawn() -> Callable[[str], bytes]:
    """The certificate of a record of the factory, by the factory's name."""
    return _bytes


@pytest.fixture
def pages() -> Callable[[str], tuple[str, ...]]:
    """The text of its pages."""
    return _pages
