"""`gyrotest simulate meter` in a process of its own, used by a plain PyVISA program."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import pyvisa

PTY = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals on this platform")
SERVED = [
    pytest.param(model, ways, id=f"{model} {' '.join(ways)}", marks=PTY if "--pty" in ways else ())
    for model in ("34401A", "34465A")
    for ways in (("--port", "0"), ("--port", "0", "--fast"), ("--pty",), ("--pty", "--fast"))
]


@contextmanager
def meter(model: str, ways: tuple[str, ...]) -> Iterator[Any]:
    """A meter that is being served, opened as any VISA user would."""
    command = [sys.executable, "-m", "gyrotest", "simulate", "meter", "--model", model, *ways]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            address = server.stdout.readline().strip()
            manager = pyvisa.ResourceManager("@py")
            with manager.open_resource(address) as opened:
                opened.timeout = 10_000
                opened.read_termination = "\n"  # type: ignore[attr-defined]
                opened.write_termination = "\n"  # type: ignore[attr-defined]
                if address.startswith("ASRL"):
                    opened.read_termination = "\r\n"  # type: ignore[attr-defined]
                    opened.write("SYST:REM")  # type: ignore[attr-defined]
                yield opened
        finally:
            server.terminate()
            server.communicate()


@pytest.mark.parametrize(("model", "ways"), SERVED)
def test_a_visa_program_finds_a_multimeter(model: str, ways: tuple[str, ...]) -> None:
    with meter(model, ways) as dmm:
        maker, name, serial_number, _ = dmm.query("*IDN?").split(",")
        assert name == model
        assert maker.split()[0].upper() in {"HEWLETT-PACKARD", "KEYSIGHT"}
        assert serial_number.startswith("SIM")
        dmm.write("*RST;*CLS")
        dmm.write("conf:volt:dc 10")
        dmm.write(":SENSe:VOLTage:DC:NPLCycles 0.2")
        assert float(dmm.query("READ?")) == pytest.approx(2.5, abs=0.1)
        dmm.write("SAMP:COUN 5")
        assert len(dmm.query_ascii_values("READ?")) == 5
        dmm.write("INIT")
        fetched = dmm.query_ascii_values("FETC?")
        assert len(fetched) == 5
        assert dmm.query_ascii_values("FETC?") == fetched
        dmm.write("TRIG:SOUR BUS;:INIT")
        dmm.write("*TRG")
        assert len(dmm.query_ascii_values("FETC?")) == 5
        dmm.write("FOO:BAR 1")
        dmm.write("VOLT:DC:NPLC 1000000")
        assert dmm.query("SYST:ERR?") == '-113,"Undefined header"'
        assert dmm.query("SYSTem:ERRor?").startswith("-222,")
        assert dmm.query("SYST:ERR?") == '+0,"No error"'


def test_a_reading_takes_its_time_unless_it_is_hurried() -> None:
    with meter("34401A", ("--port", "0")) as dmm:
        dmm.write("CONF:VOLT:DC 10,1E-5")
        began_s = time.monotonic()
        dmm.query("READ?")  # 10 power-line cycles of 20 ms, and the zero as long
        assert time.monotonic() - began_s >= 0.39
    with meter("34401A", ("--port", "0", "--fast")) as dmm:
        dmm.write("CONF:VOLT:DC 10,1E-5;:SAMP:COUN 250;:INIT")  # 100 s, far beyond the time-out
        assert len(dmm.query_ascii_values("FETC?")) == 250


def test_a_timed_record_is_fetched_in_binary_blocks() -> None:
    with meter("34465A", ("--port", "0", "--fast")) as dmm:
        dmm.write("CONF:VOLT:DC 10")
        dmm.write("SAMP:SOUR TIM;TIM 0.5;COUN 20;:FORM:DATA REAL,64")
        dmm.write("INIT")
        values = dmm.query_binary_values("R?", datatype="d", is_big_endian=True)
        assert len(values) == 20
        assert values == pytest.approx([2.5] * 20, abs=0.1)
        assert dmm.query("DATA:POIN?") == "+0"
