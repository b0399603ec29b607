"""The end of a session: close the bench, write records and certificates, say so, set the exit code."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from gyrotest.errors import GyrotestError
from gyrotest.plugin.session import GyroSession
from gyrotest.plugin.signals import hold_signals
from gyrotest.records.result import Verdict
from gyrotest.records.run import RunRecord
from gyrotest.runner.flow import UnitRun, failed_lines

_SELECTING = (("keyword", "-k"), ("markexpr", "-m"), ("deselect", "--deselect"), ("lf", "--lf"))


class Completion:
    """Writes what is owed after everything else has ended."""

    def __init__(self, session: GyroSession) -> None:
        self._session = session
        self._certificates: list[tuple[RunRecord, Path]] = []
        self._faults: list[str] = []

    def pytest_report_header(self) -> list[str]:
        """Say what is tested, with what."""
        order = self._session.order
        station = order.station.station
        simulated = " — SIMULATED" if station.simulation is not None else ""
        return [
            f"gyrotest: {order.spec.spec.model} ({order.spec.path}), serial {', '.join(order.serial_numbers)}",
            f"gyrotest: station {station.name}{simulated} ({order.station.path})",
        ]

    @pytest.hookimpl
    def pytest_deselected(self, items: list[pytest.Item]) -> None:
        """Remember what was left out, and why."""
        reason = f"deselected ({self._selection()})" if self._selection() else "deselected"
        for item in items:
            for run in self._session.runs.values():
                run.missing[item.name] = reason

    @pytest.hookimpl
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Remember why an item was skipped."""
        if report.when == "setup" and report.skipped and isinstance(report.longrepr, tuple):
            for run in self._session.runs.values():
                run.missing.setdefault(
                    report.nodeid.rpartition("::")[2], f"skipped ({report.longrepr[2]})"
                )

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int | pytest.ExitCode) -> None:
        """Close the bench; then, in the process that owns the runs, write what is owed."""
        with hold_signals():
            self._session.close_bench()
            if self._session.is_worker or self._session.observes_only:
                return
            for run in self._session.runs.values():
                self._certify(run, session, exitstatus)
        done = len(self._certificates) == len(self._session.runs) and not self._faults
        if exitstatus == pytest.ExitCode.OK and not (done and self._all_pass()):
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    @pytest.hookimpl
    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Name each certificate, its verdict and what is wrong."""
        if not self._certificates and not self._faults:
            return
        terminalreporter.section("gyrotest", sep="=")
        for record, path in self._certificates:
            for line in _summary(record, path):
                terminalreporter.write_line(line, **_colour(record.verdict))
        for fault in self._faults:
            terminalreporter.write_line(fault, red=True)

    def _certify(self, run: UnitRun, session: pytest.Session, exitstatus: int | pytest.ExitCode) -> None:
        self._explain_missing(run, session)
        whole = _WHOLE.get(int(exitstatus), "")
        try:
            record, path = run.certify(whole=whole)
            self._certificates.append((record, path))
            session.config.hook.pytest_gyro_certified(
                config=session.config, record=record, certificate=path
            )
        except GyrotestError as error:
            self._faults.append(f"{run.header.serial_number}: no certificate: {error}")
        except Exception as error:
            self._faults.append(f"{run.header.serial_number}: {type(error).__name__}: {error}")

    def _explain_missing(self, run: UnitRun, session: pytest.Session) -> None:
        stopped = session.shouldfail or session.shouldstop
        reason = f"not run ({stopped})" if stopped else ""
        if not reason and self._selection():
            reason = f"not run (selected were {self._selection()})"
        for planned in run.header.plan:
            if reason:
                run.missing.setdefault(planned.name, reason)

    def _selection(self) -> str:
        option = self._session.config.option
        chosen = ((flag, getattr(option, name, None)) for name, flag in _SELECTING)
        return ", ".join(flag if value is True else f"{flag} {value}" for flag, value in chosen if value)

    def _all_pass(self) -> bool:
        return all(record.verdict is Verdict.PASS for record, _ in self._certificates)


_WHOLE = {
    int(pytest.ExitCode.INTERRUPTED): "the run was interrupted",
    int(pytest.ExitCode.INTERNAL_ERROR): "pytest ended with an internal error",
}


def _summary(record: RunRecord, path: Path) -> Iterator[str]:
    marks = [
        word for word, is_so in (("SIMULATED", record.simulated), ("REPLAYED", record.replayed)) if is_so
    ]
    marked = f" ({', '.join(marks)})" if marks else ""
    yield f"{record.serial_number}: {record.verdict.value.replace('_', ' ')}{marked}"
    for text in failed_lines(record.results):
        yield f"  {text}"
    for text in record.missing:
        yield f"  missing: {text.splitlines()[0]}"
    yield f"  certificate: {path}"


def _colour(verdict: Verdict) -> dict[str, bool]:
    return {"green": True} if verdict is Verdict.PASS else {"red": True}
