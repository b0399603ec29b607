"""From the command line to a run: options read once at the door into frozen records."""

import os
from dataclasses import dataclass
from pathlib import Path

import pytest

from gyrotest.errors import GyrotestError, RefusedError
from gyrotest.plugin.collection import Collection
from gyrotest.plugin.completion import Completion
from gyrotest.plugin.distribution import install_distribution, runs_of_worker
from gyrotest.plugin.execution import Execution
from gyrotest.plugin.omissions import Omissions
from gyrotest.plugin.progress import progress_for
from gyrotest.plugin.prompt import Prompt
from gyrotest.plugin.session import GYRO, GyroSession
from gyrotest.plugin.signals import install_signals
from gyrotest.records.run import RunHeader
from gyrotest.runner.bench import SimulationChoice
from gyrotest.runner.door import Order, check_order, check_serial_number, open_run, reopen_run
from gyrotest.runner.folder import RunFolder
from gyrotest.runner.places import slots_of
from gyrotest.simulation.complaints import simulation_faults
from gyrotest.specification.lookup import find_spec, find_station
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

PLACEHOLDER = "SERIAL"


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What the command line, the environment and the ini file ask for."""

    order: Order
    choice: SimulationChoice
    resume: Path | None


def activate(config: pytest.Config) -> None:
    """Read the spec and the station, refuse at the door, open the runs, register the plugins."""
    try:
        session = _session(config)
    except GyrotestError as error:
        raise pytest.UsageError(*str(error).splitlines()) from error
    config.stash[GYRO] = session
    from gyrotest.plugin import fixtures

    omissions = Omissions(session)
    completion = Completion(session, omissions)
    for plugin in (fixtures, Collection(session), Execution(session), omissions, completion):
        config.pluginmanager.register(plugin)
    install_distribution(config, session)


def _session(config: pytest.Config) -> GyroSession:
    observes_only = _observes_only(config)
    prompt = Prompt(config)
    request = _request(config, observes_only=observes_only, prompt=prompt)
    worker = runs_of_worker(config)
    session = GyroSession(
        config=config,
        order=request.order,
        choice=request.choice,
        observes_only=observes_only,
        is_worker=worker is not None,
        progress=progress_for(config, request.order.spec.spec.output),
        prompt=prompt,
    )
    if observes_only:
        return session
    install_signals(config)
    config.add_cleanup(session.close_bench)
    if worker is not None:
        session.take_runs([(RunFolder(path), RunFolder(path).header()) for path in worker])
        return session
    check_order(request.order)
    session.prepare_bench()
    session.take_runs(_open_runs(request))
    return session


def _open_runs(request: Request) -> list[tuple[RunFolder, RunHeader]]:
    order = request.order
    if request.resume is not None:
        return [reopen_run(order, request.resume)]
    slots = slots_of(order.spec.spec, order.station.station)
    return [
        open_run(order, serial_number, slots[index % len(slots)])
        for index, serial_number in enumerate(order.serial_numbers)
    ]


def _observes_only(config: pytest.Config) -> bool:
    """Whether pytest only shows something and runs no test."""
    names = (
        "collectonly", "showfixtures", "show_fixtures_per_test", "setupplan", "markers", "cacheshow",
    )  # fmt: skip
    return any(config.getoption(name, default=False) for name in names)


def _request(config: pytest.Config, *, observes_only: bool, prompt: Prompt) -> Request:
    option = config.option
    spec = load_spec(_spec_path(config))
    station = load_station(_station_path(config), simulation=simulation_faults)
    serial_numbers = _serial_numbers(option.gyro_serial, observes_only=observes_only)
    for serial_number in serial_numbers:
        if serial_number != PLACEHOLDER or not observes_only:
            check_serial_number(serial_number, spec.spec.serial_pattern)
    order = Order(
        spec=spec,
        station=station,
        serial_numbers=serial_numbers,
        out=_out(config),
        operator=option.gyro_operator or config.getini("gyro_operator"),
        meta=_meta(option.gyro_meta),
        command=" ".join(["pytest", *(str(one) for one in config.invocation_params.args)]),
        one_after_another=prompt.answered,
    )
    return Request(
        order=order,
        choice=_choice(config),
        resume=_from_invocation(config, option.gyro_resume) if option.gyro_resume else None,
    )


def _spec_path(config: pytest.Config) -> Path:
    given = config.option.gyro_spec
    if len(given) > 1 and not runs_of_worker(config):
        raise RefusedError(f"--gyro-spec is given {len(given)} times; one run tests by one spec")
    folders = (config.invocation_params.dir, config.rootpath / config.getini("gyro_spec_dir"))
    return find_spec(given[0], folders).resolve()


def _station_path(config: pytest.Config) -> Path:
    name = (
        config.option.gyro_station
        or os.environ.get("GYRO_STATION")
        or config.getini("gyro_station")
        or "simulated"
    )
    spec_dir = config.rootpath / config.getini("gyro_spec_dir")
    folders = (config.invocation_params.dir, config.rootpath, spec_dir / "stations", spec_dir)
    return find_station(name, folders).resolve()


def _serial_numbers(given: list[str] | None, *, observes_only: bool) -> tuple[str, ...]:
    if given and len(given) > 1:
        raise RefusedError(
            f"serial numbers are given {len(given)} times; write them once, several with commas: --serial SN,SN"
        )
    found = tuple(one.strip() for one in (given or [""])[0].split(","))
    if any(found):
        return found
    if given is None and observes_only:
        return (PLACEHOLDER,)
    raise RefusedError(
        "--gyro-spec needs the serial number of the unit under test: add --serial SN (or --gyro-serial SN)"
    )


def _meta(given: list[str]) -> dict[str, str]:
    pairs = [one.partition("=") for one in given]
    for key, equals, value in pairs:
        if not equals or not key.strip() or len(key) + len(value) > 500:
            raise RefusedError(
                f"--gyro-meta '{key}{equals}{value[:40]}': expected KEY=VALUE, e.g. order=4711"
            )
    meta = {key.strip(): value.strip() for key, _, value in pairs}
    if len(meta) < len(pairs):
        raise RefusedError(f"--gyro-meta: a key is given twice in {', '.join(given)[:200]}")
    return meta


def _choice(config: pytest.Config) -> SimulationChoice:
    seed = config.option.gyro_sim_seed
    if seed is not None and not str(seed).isdecimal():
        raise RefusedError(f"--gyro-sim-seed '{seed}': expected a whole number from 0, e.g. 1")
    return SimulationChoice(
        scenario=config.option.gyro_sim_scenario,
        seed=None if seed is None else int(seed),
        real_time=config.option.gyro_real_time,
    )


def _out(config: pytest.Config) -> Path:
    """The option counts from where pytest was started, the ini file's entry from the ini file."""
    if config.option.gyro_out:
        return _from_invocation(config, config.option.gyro_out)
    base = config.inipath.parent if config.inipath else config.invocation_params.dir
    return (base / str(config.getini("gyro_out"))).resolve()


def _from_invocation(config: pytest.Config, path: str) -> Path:
    return (config.invocation_params.dir / path).resolve()
