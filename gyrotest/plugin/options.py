"""The pytest entry point: the command line, and nothing else unless a spec is given."""

import argparse
from collections.abc import Generator

import pytest

_GROUP = "gyrotest"
_OPTIONS: tuple[tuple[str, str, str], ...] = (
    (
        "--gyro-station",
        "PATH|NAME",
        "station file, or the name of a shipped station (default: simulated)",
    ),
    ("--gyro-operator", "NAME", "who runs the test; printed on the certificate"),
    ("--gyro-out", "DIR", "where the runs' folders are made (default: reports)"),
    ("--gyro-resume", "RUN", "go on with an interrupted run: its folder"),
    ("--gyro-sim-scenario", "NAME", "simulated bench: what goes wrong (default: as the station says)"),
    ("--gyro-sim-seed", "N", "simulated bench: seed of the units and their noise"),
)
_INI: tuple[tuple[str, str, str], ...] = (
    ("gyro_spec_dir", "specs", "gyrotest: folder under the rootdir in which specs are looked up"),
    ("gyro_station", "", "gyrotest: default of --gyro-station"),
    ("gyro_operator", "", "gyrotest: default of --gyro-operator"),
    ("gyro_out", "reports", "gyrotest: default of --gyro-out"),
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Register the options; all wait for `--gyro-spec`."""
    group = parser.getgroup(_GROUP, "gyrotest: production tests of gyroscopes")
    group.addoption(
        "--gyro-spec",
        action="append",
        dest="gyro_spec",
        metavar="SPEC",
        help="the gyro model's spec: a path, or a name looked up in gyro_spec_dir and among the shipped ones",
    )
    group.addoption(
        "--gyro-serial",
        action="append",
        dest="gyro_serial",
        metavar="SN[,SN…]",
        help="serial number of the unit under test (--serial too, where the project has no such option)",
    )
    group.addoption(
        "--gyro-meta",
        action="append",
        dest="gyro_meta",
        default=[],
        metavar="KEY=VALUE",
        help="order, batch, temperature, …: kept on record and printed on the certificate; may be repeated",
    )
    for name, metavar, text in _OPTIONS:
        group.addoption(name, dest=name[2:].replace("-", "_"), metavar=metavar, help=text)
    group.addoption(
        "--gyro-yes", action="store_true", dest="gyro_yes", help="answer every prompt with yes"
    )
    group.addoption(
        "--gyro-real-time",
        action="store_true",
        dest="gyro_real_time",
        help="simulated bench: let time pass as it does on a real one",
    )
    for key, default, text in _INI:
        parser.addini(key, text, default=default)


def pytest_addhooks(pluginmanager: pytest.PytestPluginManager) -> None:
    """Declare gyrotest's own hooks."""
    from gyrotest.plugin import hookspecs

    pluginmanager.add_hookspecs(hookspecs)


@pytest.hookimpl(wrapper=True)
def pytest_load_initial_conftests(
    early_config: pytest.Config, parser: pytest.Parser
) -> Generator[None, None, None]:
    """Offer `--serial` when a spec is given and no conftest or plugin has taken the name."""
    yield
    if not early_config.known_args_namespace.gyro_spec:
        return
    group = parser.getgroup(_GROUP)
    try:
        group.addoption(
            "--serial",
            action="append",
            dest="gyro_serial",
            metavar="SN[,SN…]",
            help="same as --gyro-serial",
        )
    except (ValueError, argparse.ArgumentError):
        return


def pytest_configure(config: pytest.Config) -> None:
    """Wake up if a spec is given; otherwise do nothing at all."""
    if config.getoption("gyro_spec") and not config.getoption("help"):
        _spare_rewriting(config)
        from gyrotest.plugin.activation import activate

        activate(config)


def _spare_rewriting(config: pytest.Config) -> None:
    """Keep pytest from rewriting assertions in gyrotest itself, which has none.

    pytest marks whole packages that bring plugins; where no bytecode is kept (a read-only
    installation) that costs each run more than a second.
    """
    marked = getattr(config.pluginmanager.rewrite_hook, "_must_rewrite", None)
    if isinstance(marked, set):
        marked.discard("gyrotest")
