"""Turns of the dialogue with a multimeter, and a clock that only moves when it is told to."""

from datetime import UTC, datetime, timedelta

from gyrotest.instruments.transport.dialogue import Turn

NO_ERROR = b'+0,"No error"\n'
ERRORS: list[Turn] = [(b"SYST:ERR?\n", NO_ERROR)]

IDN_34401A = b"HEWLETT-PACKARD,34401A,0,11-5-2\n"
IDN_34465A = b"Keysight Technologies,34465A,MY54500001,A.02.14\n"


def opening(identity: bytes) -> list[Turn]:
    return [(b"*IDN?\n", identity), (b"*CLS;*RST\n", None)]


def applied_34401a(
    *, count: int, nplc: str = "10", autozero: bool = True, **replies: bytes
) -> list[Turn]:
    """The configuration of a 34401A at 10 V; with another reply to a query (by name) it ends there."""
    resolution = {"0.02": "1E-03", "1": "3E-05", "10": "1E-05", "100": "3E-06"}[nplc]
    read_back = {
        "RANG": ("VOLT:DC:RANG?", "+1.000000E+01"),
        "NPLC": ("VOLT:DC:NPLC?", f"{float(nplc):+.6E}"),
        "IMP": ("INP:IMP:AUTO?", "1"),
        "ZERO": ("ZERO:AUTO?", str(int(autozero))),
        "SOUR": ("TRIG:SOUR?", "IMM"),
        "COUN": ("TRIG:COUN?", "+1.000000E+00"),
        "DEL": ("TRIG:DEL?", "+0.000000E+00"),
        "SAMP": ("SAMP:COUN?", f"+{count}"),
    }
    commands = (
        f"CONF:VOLT:DC 10,{resolution}",
        f"VOLT:DC:NPLC {nplc}",
        "INP:IMP:AUTO ON",
        f"ZERO:AUTO {'ON' if autozero else 'OFF'}",
        "TRIG:SOUR IMM",
        "TRIG:COUN 1",
        "TRIG:DEL 0",
        f"SAMP:COUN {count}",
        "DISP OFF",
    )
    turns: list[Turn] = [*((f"{one}\n".encode(), None) for one in commands), *ERRORS]
    for name, (query, reply) in read_back.items():
        turns.append((f"{query}\n".encode(), replies.get(name, f"{reply}\n".encode())))
        if name in replies:
            break
    return turns


def applied_34465a(*, least: bytes = b"+4.0002E-01", timer: str = "0.500000") -> list[Turn]:
    """The configuration of a 34465A: 10 V, 10 power-line cycles of 50 Hz, autozero."""
    return [
        (b"CONF:VOLT:DC 10\n", None),
        (b"VOLT:DC:NPLC 10\n", None),
        (b"VOLT:DC:ZERO:AUTO ON\n", None),
        (b"VOLT:DC:IMP:AUTO ON\n", None),
        (b"TRIG:SOUR IMM\n", None),
        (b"TRIG:COUN 1\n", None),
        (b"TRIG:DEL 0\n", None),
        (b"DISP OFF\n", None),
        *ERRORS,
        (b"VOLT:DC:RANG?\n", b"+1.00000000E+01\n"),
        (b"VOLT:DC:NPLC?\n", b"+1.00000000E+01\n"),
        (b"VOLT:DC:ZERO:AUTO?\n", b"1\n"),
        (b"VOLT:DC:IMP:AUTO?\n", b"1\n"),
        (b"TRIG:SOUR?\n", b"IMM\n"),
        (b"TRIG:COUN?\n", b"+1.00000000E+00\n"),
        (b"TRIG:DEL?\n", b"+0.00000000E+00\n"),
        (b"SAMP:TIM? MIN\n", least + b"\n"),
        (b"SAMP:SOUR TIM\n", None),
        (b"SAMP:TIM %s\n" % timer.encode(), None),
        (b"FORM:DATA REAL,64\n", None),
        (b"FORM:BORD NORM\n", None),
        *ERRORS,
        (b"SAMP:SOUR?\n", b"TIM\n"),
        (b"FORM:DATA?\n", b"REAL,64\n"),
        (b"FORM:BORD?\n", b"NORM\n"),
        (b"SAMP:TIM?\n", b"+%.8fE+00\n" % float(timer)),
    ]


class StepClock:
    """Time that moves to where it is waited for; `late_s` is added once to the next wait."""

    def __init__(self) -> None:
        self.time_s = 1000.0
        self.late_s = 0.0
        self.waits: list[float] = []

    def now_s(self) -> float:
        return self.time_s

    def utc(self) -> datetime:
        return datetime(2026, 1, 1, tzinfo=UTC) + timedelta(seconds=self.time_s)

    def sleep_until(self, deadline_s: float) -> None:
        self.waits.append(deadline_s)
        self.time_s = max(self.time_s, deadline_s) + self.late_s
        self.late_s = 0.0
