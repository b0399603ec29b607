"""The end of a session: close the bench, write records and certificates, say so, set the exit code."""

from collections.abc import Generator, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from gyrotest.errors import GyrotestError
from gyrotest.plugin.omissions import Omissions
from gyrotest.plugin.session import GyroSession
from gyrotest.plugin.signals import hold_signals
from gyrotest.records.result import Verdict
from gyrotest.records.run import RunRecord
from gyrotest.runner.flow import UnitRun, failed_lines

_SUMMARISED = (0, 1, 2, 4, 5)  # the exit codes after which pytest asks for terminal summaries


class Completion:
    """Writes what is owed after everything else has ended, however it ended."""

    def __init__(self, session: GyroSession, omissions: Omissions) -> None:
        self._session = session
        self._omissions = omissions
        self._pytest_session: pytest.Session | None = None
        self._certificates: list[tuple[RunRecord, Path]] = []
        self._faults: list[str] = []
        self._finished = False
        session.config.add_cleanup(self._after_all)

    def pytest_report_header(self) -> list[str]:
        """Say what is tested, with what."""
        order = self._session.order
        station = order.station.station
        simulated = " — SIMULATED" if station.simulation is not None else ""
        return [
            f"gyrotest: {order.spec.spec.model} ({order.spec.path}), serial {', '.join(order.serial_numbers)}",
            f"gyrotest: station {station.name}{simulated} ({order.station.path})",
        ]

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_sessionfinish(
        self, session: pytest.Session, exitstatus: int | pytest.ExitCode
    ) -> Generator[None, None, None]:
        """Write what is owed, after fixtures have been closed, also where another hook breaks."""
        self._pytest_session = session
        summarised = False
        try:
            yield
            summarised = int(exitstatus) in _SUMMARISED
        except BaseException as fault:
            self._omissions.add(f"the session's end failed ({_described(fault)})")
            raise
        finally:
            self._finish()
            self._correct_exit_code()
            if not summarised:
                self._say()

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

    def _finish(self) -> None:
        self._finished = True
        with hold_signals():
            self._session.close_bench()
            if self._session.is_worker or self._session.observes_only:
                return
            for run in self._session.runs.values():
                self._omissions.explain(run, self._pytest_session)
                self._certify(run)

    def _after_all(self) -> None:
        """Write what is still owed where the session never began; let nobody lower the exit code."""
        if not self._finished:
            self._omissions.add("the session did not begin")
            self._finish()
            self._say()
        self._correct_exit_code()

    def _correct_exit_code(self) -> None:
        if self._session.is_worker or self._session.observes_only or self._pytest_session is None:
            return
        if self._pytest_session.exitstatus == pytest.ExitCode.OK and not self._all_pass():
            self._pytest_session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def _certify(self, run: UnitRun) -> None:
        try:
            record, path = run.certify(whole=self._omissions.whole)
        except Exception as error:
            fault = f"no certificate: {_described(error)}"
            self._faults.append(f"{run.header.serial_number}: {fault}")
            with suppress(GyrotestError):
                run.update_record(whole=fault)
            return
        self._certificates.append(self._announced(run, record, path))

    def _announced(self, run: UnitRun, record: RunRecord, path: Path) -> tuple[RunRecord, Path]:
        """Call the hook; where it breaks, no certificate that says PASS stays behind."""
        hook = self._session.config.hook
        try:
            hook.pytest_gyro_certified(config=self._session.config, record=record, certificate=path)
        except BaseException as error:  # pytest's own outcomes, too; signals are held
            fault = f"hook pytest_gyro_certified: {_described(error)}"
            self._faults.append(f"{record.serial_number}: {fault}")
            if record.verdict in {Verdict.PASS, Verdict.CONDITIONAL_PASS}:
                return run.withdraw(path, fault)
        return record, path

    def _say(self) -> None:
        reporter = self._session.config.pluginmanager.getplugin("terminalreporter")
        if reporter is not None and not self._session.is_worker:
            self.pytest_terminal_summary(reporter)

    def _all_pass(self) -> bool:
        passed = [record for record, _ in self._certificates if record.verdict is Verdict.PASS]
        return len(passed) == len(self._session.runs) and not self._faults


def _described(error: BaseException) -> str:
    return str(error) if isinstance(error, GyrotestError) else f"{type(error).__name__}: {error}"


def _summary(record: RunRecord, path: Path) -> Iterator[str]:
    marks = [
        word for word, is_so in (("SIMULATED", record.simulated), ("REPLAYED", record.replayed)) if is_so
    ]
    marked = f" ({', '.join(marks)})" if marks else ""
    yield f"{record.serial_number}: {record.verdict.value.replace('_', ' ')}{marked}"
    for item in record.items:
        for text in failed_lines(item.last.results if item.last else ()):
            yield f"  {item.plan.name}: {text}"
    for text in record.missing:
        yield f"  missing: {text.splitlines()[0]}"
    yield f"  certificate: {path}"


def _colour(verdict: Verdict) -> dict[str, bool]:
    return {"green": True} if verdict is Verdict.PASS else {"red": True}
