"""The fixtures: the acquisition behind the spec's items, and what a user's own tests may ask for."""

from collections.abc import Callable

import pytest

from gyrotest.plugin.collection import SERIAL_NUMBER, LimitsNotMet
from gyrotest.plugin.own_tests import GyroAcquire, GyroInstrument, GyroVerify
from gyrotest.plugin.properties import add_properties
from gyrotest.plugin.session import GYRO, PLANNED, GyroSession
from gyrotest.records.spec import Spec
from gyrotest.records.station import Station
from gyrotest.runner.flow import Acquired, LackingError, failed_lines


@pytest.fixture
def gyro_acquired(request: pytest.FixtureRequest) -> Acquired:
    """The acquisition of a spec's item: made now, unless it stands made before."""
    session = request.config.stash[GYRO]
    run = session.put_on_bench(request.node.stash[SERIAL_NUMBER])
    acquired = run.acquire(request.node.stash[PLANNED])
    request.config.hook.pytest_gyro_acquired(item=request.node, attempt=acquired.attempt)
    return acquired


@pytest.fixture
def gyro_judgement(request: pytest.FixtureRequest) -> Callable[[Acquired | None], None]:
    """Judge a spec's item and put it on record."""
    session = request.config.stash[GYRO]
    run = session.runs[request.node.stash[SERIAL_NUMBER]]
    planned = request.node.stash[PLANNED]

    def judged(acquired: Acquired | None) -> None:
        try:
            attempt = run.judge_repeats(planned) if acquired is None else run.judge(planned, acquired)
        except LackingError as lacking:
            pytest.skip(str(lacking))
        add_properties(request.node, attempt.results)
        request.config.hook.pytest_gyro_judged(item=request.node, attempt=attempt)
        if lines := failed_lines(attempt.results):
            raise LimitsNotMet("\n".join(lines))

    return judged


@pytest.fixture(scope="session")
def gyro_session(request: pytest.FixtureRequest) -> GyroSession:
    """Return the session's state; for gyrotest's own fixtures."""
    return request.config.stash[GYRO]


@pytest.fixture(scope="session")
def gyro_spec(gyro_session: GyroSession) -> Spec:
    """The spec of the gyro model."""
    return gyro_session.order.spec.spec


@pytest.fixture(scope="session")
def gyro_station(gyro_session: GyroSession) -> Station:
    """The station that the run uses."""
    return gyro_session.order.station.station


@pytest.fixture(scope="session")
def gyro_serial(request: pytest.FixtureRequest, gyro_session: GyroSession) -> str:
    """The serial number of the unit under test; with several, the test runs once for each."""
    return str(getattr(request, "param", gyro_session.order.serial_numbers[0]))


@pytest.fixture(scope="session")
def instrument(gyro_session: GyroSession, gyro_serial: str) -> GyroInstrument:
    """The bench's primary source for the unit under test; reconnects by itself."""
    return GyroInstrument(gyro_session, gyro_serial)


@pytest.fixture
def gyro_acquire(
    request: pytest.FixtureRequest, gyro_session: GyroSession, gyro_serial: str
) -> GyroAcquire:
    """Acquire a record of any length: `gyro_acquire(duration='10 s', interval='0.1 s')`."""
    return GyroAcquire(gyro_session, gyro_serial, request.node)


@pytest.fixture
def gyro_verify(
    request: pytest.FixtureRequest, gyro_session: GyroSession, gyro_serial: str
) -> GyroVerify:
    """Judge a value like the spec's own: `gyro_verify('offset', 2.51, unit='V', max='2.6 V')`."""
    verify = GyroVerify(gyro_session, gyro_session.runs[gyro_serial], request.node)
    request.node.stash[VERIFY] = verify
    return verify


VERIFY = pytest.StashKey[GyroVerify]()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run a user's own test once for each serial number."""
    serial_numbers = metafunc.config.stash[GYRO].order.serial_numbers
    if "gyro_serial" in metafunc.fixturenames and len(serial_numbers) > 1:
        metafunc.parametrize("gyro_serial", serial_numbers, indirect=True, scope="session")
