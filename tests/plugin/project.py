"""A user's project with a short spec, run by pytest in a process of its own."""

import json
import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

SPEC = """
model: SHORT50
description: A short test of an analogue gyro
serial_pattern: '[0-9]{{4,8}}'
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
cases:
  rest:
    procedure: static
    warm_up: 1 min
    duration: {duration}
    interval: 1 s
    repeats: {repeats}
    mounting: [1, 0, 0]
    parameters: {{smoothing: [1 s, 10 s]}}
    limits:
      bias: {{min: -2 deg/s, max: {bias_max}}}
      bias_stability_1s: {{max: 200 deg/h}}
      angle_random_walk: {{max: 1 deg/sqrt(h)}}
      bias_run_to_run: {{max: 200 deg/h, over: repeats}}
"""


TINY = """
model: TINY50
serial_pattern: '[0-9]{4,8}'
output: {kind: voltage, scale_factor: 50 mV/(deg/s), zero_rate: 2.5 V, full_scale: 100 deg/s}
cases:
  rest:
    procedure: static
    duration: 40 s
    interval: 1 s
    parameters: {smoothing: [1 s]}
    limits: {bias: {min: -2 deg/s, max: 2 deg/s}}
"""
FAILING = TINY.replace("min: -2 deg/s, max: 2 deg/s", "min: -2 deg/s, max: -1.9 deg/s")


def short_spec(*, duration: str = "4 min", repeats: int = 2, bias_max: str = "2 deg/s") -> str:
    text = SPEC.format(duration=duration, repeats=repeats, bias_max=bias_max)
    if repeats == 1:
        text = "\n".join(line for line in text.splitlines() if "bias_run_to_run" not in line)
    return text


@dataclass
class Ended:
    """How a pytest process ended."""

    code: int
    out: str

    def __contains__(self, text: str) -> bool:
        return text in self.out


@dataclass(frozen=True)
class Session:
    """One of several pytest sessions that share a process: arguments, a plugin of its own, a spec."""

    _: KW_ONLY
    arguments: tuple[str, ...] = ()
    plugin: str = ""
    spec: str = "short.yaml"
    serial: str | None = "1234"


@dataclass(frozen=True)
class SessionEnded:
    """How one of these sessions ended.

    The code is None where an exception came out of pytest, the record where no run was begun.
    """

    code: int | None
    out: str
    record: Any
    certificates: list[str]


_SESSIONS = """
import json, signal, sys, traceback
import pytest
sys.path.insert(0, "")
before = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)]
for number, arguments in enumerate(json.loads(sys.argv[1])):
    try:
        code = int(pytest.main(arguments))
    except BaseException:
        traceback.print_exc(file=sys.stdout)
        code = None
    assert before == [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)]
    print(f"\\n--- session {number} ended: {json.dumps(code)}", flush=True)
"""


class Project:
    """A folder with a spec, and pytest processes in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        (path / "specs").mkdir()
        (path / "pytest.ini").write_text("[pytest]\n", encoding="utf-8")
        self.write("specs/short.yaml", short_spec())

    def write(self, name: str, text: str) -> Path:
        path = self.path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return path

    def pytest(
        self,
        *arguments: str,
        spec: str | None = "short.yaml",
        serial: str | None = "1234",
        environment: Mapping[str, str] = MappingProxyType({}),
        folder: str = ".",
    ) -> Ended:
        return _ended(
            self.start(*arguments, spec=spec, serial=serial, environment=environment, folder=folder)
        )

    def start(
        self,
        *arguments: str,
        spec: str | None = "short.yaml",
        serial: str | None = "1234",
        environment: Mapping[str, str] = MappingProxyType({}),
        folder: str = ".",
    ) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments]
        if "--cache" in arguments:
            command = [sys.executable, "-m", "pytest", *[one for one in arguments if one != "--cache"]]
        if spec is not None:
            command += ["--gyro-spec", spec]
        if serial is not None:
            command += ["--serial", serial]
        return self._popen(command, environment, folder)

    def sessions(self, *sessions: Session) -> list[SessionEnded]:
        """Run pytest sessions one after another in one process, which spares most of their time."""
        for number, one in enumerate(sessions):
            self.write(f"plugin_{number}.py", one.plugin)
        lines = [
            ["-p", "no:cacheprovider", "-p", f"plugin_{number}", *one.arguments, "--gyro-spec", one.spec,
             *(() if one.serial is None else (f"--serial={one.serial}",)), "--gyro-out", f"out_{number}"]
            for number, one in enumerate(sessions)
        ]  # fmt: skip
        ended = _ended(self._popen([sys.executable, "-c", _SESSIONS, json.dumps(lines)]))
        found = re.split(r"\n--- session \d+ ended: (\d+|null)\n", ended.out)
        assert ended.code == 0, ended.out
        return [
            self._session_ended(number, out, code)
            for number, (out, code) in enumerate(zip(found[0:-1:2], found[1::2], strict=True))
        ]

    def _session_ended(self, number: int, out: str, code: str) -> SessionEnded:
        runs = [*(self.path / f"out_{number}").glob("*/*/run.json")]
        assert len(runs) <= 1, out
        return SessionEnded(
            code=json.loads(code),
            out=out,
            record=json.loads(runs[0].read_text(encoding="utf-8")) if runs else None,
            certificates=[path.name for run in runs for path in run.parent.glob("*.pdf")],
        )

    def gyrotest(self, *arguments: str) -> Ended:
        return _ended(self._popen([sys.executable, "-m", "gyrotest", *arguments]))

    def python(self, code: str) -> Ended:
        return _ended(self._popen([sys.executable, "-c", textwrap.dedent(code)]))

    def _popen(
        self,
        command: Sequence[str],
        more: Mapping[str, str] = MappingProxyType({}),
        folder: str = ".",
    ) -> subprocess.Popen[str]:
        foreign = ("PYTEST_", "GYRO_", "COV_")
        environment = {key: value for key, value in os.environ.items() if not key.startswith(foreign)}
        environment |= {"PYTHONIOENCODING": "utf-8", **more}
        return subprocess.Popen(  # the tests' own command lines
            command,
            cwd=self.path / folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
        )

    def runs(self, serial: str = "1234") -> list[Path]:
        return sorted(path.parent for path in (self.path / "reports" / serial).glob("*/run.json"))

    def record(self, serial: str = "1234") -> dict[str, Any]:
        loaded = json.loads((self.runs(serial)[-1] / "run.json").read_text(encoding="utf-8"))
        assert isinstance(loaded, dict)
        return loaded

    def certificates(self, serial: str = "1234") -> list[Path]:
        return sorted((self.path / "reports" / serial).glob("*/*.pdf"))


def _ended(process: subprocess.Popen[str]) -> Ended:
    out, _ = process.communicate(timeout=120)
    return Ended(process.returncode, out)
