"""While items run: our errors as their message, the record after each item, nothing lost to a hook."""

from collections.abc import Generator
from typing import Any

import pytest

from gyrotest.errors import GyrotestError
from gyrotest.plugin.collection import SERIAL_NUMBER, LimitsNotMet
from gyrotest.plugin.fixtures import VERIFY
from gyrotest.plugin.own_tests import GyroVerify
from gyrotest.plugin.properties import clear_properties
from gyrotest.plugin.session import PLANNED, GyroSession
from gyrotest.records.run import Outcome

_VERDICTS = (AssertionError, LimitsNotMet, pytest.fail.Exception)


class Execution:
    """Watches the items of the spec, and a user's own tests that judge values."""

    def __init__(self, session: GyroSession) -> None:
        self._session = session

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Forget what an earlier attempt reported."""
        clear_properties(item)

    @pytest.hookimpl(wrapper=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
        """Fail a user's own test at its end where a value that it judged is out of limits."""
        verify = pyfuncitem.stash.get(VERIFY, None)
        if verify is not None and verify.failed_before:
            raise LimitsNotMet(verify.failed_before)
        called = yield
        if verify is not None and verify.not_met():
            raise LimitsNotMet("\n".join(verify.not_met()))
        return called

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Show our own errors as their message, and keep every failure on record."""
        report = yield
        if call.excinfo is not None and isinstance(call.excinfo.value, GyrotestError | LimitsNotMet):
            report.longrepr = _message_only(call.excinfo)
        if VERIFY in item.stash:
            _keep_own(item.stash[VERIFY], report, call)
        if PLANNED in item.stash and (call.excinfo is not None or report.failed):
            self._keep(item, report, call)
        return report

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logfinish(self) -> None:
        """Replace `run.json` after each item, so that what is done stands whatever comes."""
        if self._session.observes_only or self._session.is_worker:
            return
        for run in self._session.runs.values():
            run.note_progress()

    def _keep(self, item: pytest.Item, report: pytest.TestReport, call: pytest.CallInfo[None]) -> None:
        """Let no item stand as passed that something went wrong with, whatever its marks make of that."""
        fault = call.excinfo.value if call.excinfo is not None else None
        skipped_at_once = isinstance(fault, pytest.skip.Exception) and call.when == "setup"
        run = self._session.runs.get(item.stash[SERIAL_NUMBER])
        if run is None or skipped_at_once or isinstance(fault, LimitsNotMet):
            return
        run.fail(item.stash[PLANNED].name, f"{call.when}: {_text(report, fault)}")


def _keep_own(verify: GyroVerify, report: pytest.TestReport, call: pytest.CallInfo[None]) -> None:
    fault = call.excinfo.value if call.excinfo is not None else None
    if call.when == "call":
        verify.close(_outcome(report, fault), _text(report, fault))
    elif fault is not None:
        verify.spoil(f"{call.when}: {_text(report, fault)}")


def _outcome(report: pytest.TestReport, fault: BaseException | None) -> Outcome:
    if isinstance(fault, pytest.skip.Exception):
        return Outcome.SKIPPED
    if isinstance(fault, _VERDICTS) or (fault is None and report.failed):
        return Outcome.FAILED
    return Outcome.PASSED if fault is None else Outcome.ERROR


def _text(report: pytest.TestReport, fault: BaseException | None) -> str:
    if fault is None:
        return str(report.longrepr) if report.failed else ""
    return str(fault) or type(fault).__name__


def _message_only(excinfo: pytest.ExceptionInfo[BaseException]) -> Any:
    shown = excinfo.getrepr(style="value", chain=False)
    if shown.reprcrash is not None:
        shown.reprcrash.message = str(excinfo.value)
    return shown
