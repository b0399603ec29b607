"""While items run: our errors as their message, the record after each item, nothing lost to a hook."""

from collections.abc import Generator
from typing import Any

import pytest

from gyrotest.errors import GyrotestError
from gyrotest.plugin.collection import SERIAL_NUMBER, LimitsNotMet
from gyrotest.plugin.fixtures import VERIFY
from gyrotest.plugin.session import PLANNED, GyroSession
from gyrotest.records.run import Outcome


class Execution:
    """Watches the items of the spec, and a user's own tests that judge values."""

    def __init__(self, session: GyroSession) -> None:
        self._session = session

    @pytest.hookimpl(wrapper=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
        """Fail a user's own test at its end where a value that it judged is out of limits."""
        called = yield
        verify = pyfuncitem.stash.get(VERIFY, None)
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
        self._keep(item, report, call)
        return report

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logfinish(self) -> None:
        """Replace `run.json` after each item, so that what is done stands whatever comes."""
        if self._session.observes_only or self._session.is_worker:
            return
        for run in self._session.runs.values():
            run.update_record()

    def _keep(self, item: pytest.Item, report: pytest.TestReport, call: pytest.CallInfo[None]) -> None:
        verify = item.stash.get(VERIFY, None)
        if verify is not None and report.when == "call":
            verify.close(Outcome.PASSED if report.passed else Outcome.FAILED, _text(call))
        if PLANNED not in item.stash or not report.failed:
            return
        if call.excinfo is not None and isinstance(call.excinfo.value, LimitsNotMet):
            return
        run = self._session.runs.get(item.stash[SERIAL_NUMBER])
        if run is not None:
            run.fail(item.stash[PLANNED].name, f"{report.when}: {_text(call)}")


def _text(call: pytest.CallInfo[None]) -> str:
    if call.excinfo is None:
        return ""
    return str(call.excinfo.value) or type(call.excinfo.value).__name__


def _message_only(excinfo: pytest.ExceptionInfo[BaseException]) -> Any:
    shown = excinfo.getrepr(style="value")
    if shown.reprcrash is not None:
        shown.reprcrash.message = str(excinfo.value)
    return shown
