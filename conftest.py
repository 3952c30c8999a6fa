"""Fixtures for every test: isolated worlds, the transports, and a look at what was left behind."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TypeAlias

import pytest
from helpers.isolation import (
    claim_slot,
    isolated_env,
    keep_bytecode,
    keep_runs_within_runs_apart,
    log_directory,
)
from helpers.leaks import Inventory
from helpers.wires import DDS, TRANSPORTS, require_wire
from hypothesis import HealthCheck, settings

from goalwire import fault_reports, logging
from goalwire.execution.signals.signal_pipe import signal_pipe
from goalwire.logging import LogRecord
from goalwire.transport import registry
from goalwire.transport.contract import Session, SessionOptions

OpenSession: TypeAlias = Callable[[], Session]

os.environ['ROS_LOG_DIR'] = str(log_directory())  # never the home of who runs the tests
keep_bytecode()

# The first text takes a second, while Hypothesis makes its table of Unicode. Other examples may be slow, too.
settings.register_profile('any speed', deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('any speed')

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell's background jobs are deaf to Ctrl-C, and so would be the programs that tests start.
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, 'SIGHUP') and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    # `nohup` makes the tests deaf to a closed terminal, and they stay so: a handler of Python's does nothing
    # here, and the programs that tests start do not inherit it.
    signal.signal(signal.SIGHUP, lambda _number, _frame: None)


@pytest.fixture(autouse=True, scope='session')
def runs_within_this_run(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep the files of pytest's runs that tests start apart from those of this run."""
    tmp_path_factory.getbasetemp()  # first: this run's own folder must not move
    keep_runs_within_runs_apart()


@pytest.fixture(autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """Fail a test that leaves a thread, an executor, a session, a file or a network socket behind."""
    claim_slot()
    signal_pipe('listener'), signal_pipe('loop')  # they stay open as long as the process
    before = Inventory()
    yield
    assert _running_executors() == [], 'executors that still count as running on this thread'
    assert before.added_threads() == [], 'threads left running'
    assert _open_memory_sessions() == 0, 'sessions of the memory transport left open'
    assert before.added_descriptors() == [], 'file descriptors left open'


@pytest.fixture(autouse=True)
def nothing_told_before() -> None:
    """Forget the faults of earlier tests: each is logged once in a process, and here once in a test."""
    fault_reports._failures.clear()


@pytest.fixture
def records() -> Iterator[list[LogRecord]]:
    """The records that are logged during the test."""
    seen: list[LogRecord] = []
    with logging.add_sink(seen.append):
        yield seen


def _running_executors() -> list[object]:
    """Take out what the tests after this one would be blamed for."""
    module = sys.modules.get('goalwire.execution.current_callback')
    if module is None:
        return []
    executors: list[object] = module.active_executors.executors
    left, executors[:] = list(executors), []
    return left


def _open_memory_sessions() -> int:
    module = sys.modules.get('goalwire.transport.memory.domain')
    return module.DOMAINS.users() if module else 0


@pytest.hookimpl(optionalhook=True)  # without pytest-xdist nobody asks
def pytest_xdist_auto_num_workers() -> int:
    """Three more than there are cores: most of a test's time it waits for others."""
    cores = len(os.sched_getaffinity(0)) if sys.platform == 'linux' else os.cpu_count() or 1
    return int(os.environ.get('PYTEST_XDIST_AUTO_NUM_WORKERS') or cores + 3)


def pytest_configure(config: pytest.Config) -> None:
    """Have each worker of a whole run import the test files from another one on.

    In a fresh clone pytest compiles each of them, which takes three times as long as all the rest of the
    collection. Workers that go the same way compile the same files at the same time; so they share the work.
    """
    worker = os.environ.get('PYTEST_XDIST_WORKER')
    if worker and config.args == config.getini('testpaths'):
        entries = sorted(entry for folder in config.args for entry in Path(config.rootpath, folder).iterdir())
        parts = [entry for entry in entries if entry.is_dir() or entry.match('test_*.py')]
        workers = int(os.environ['PYTEST_XDIST_WORKER_COUNT'])
        first = len(parts) * int(worker.removeprefix('gw')) // workers
        config.args = [str(part) for part in parts[first:] + parts[:first]]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage meanwhile, and never again among the 350 000 objects that come: they stay.

    A test that collects garbage would pay up to a second for them.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        import hypothesis  # noqa: F401 - as it is imported it asks who holds what, and sees nothing frozen

        gc.collect()
        gc.freeze()
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that have the most slow tests: no worker is left with one of them at the end.

    Every worker has the same order, in whichever it has imported the files.
    """
    slow = Counter(item.path for item in items if item.get_closest_marker('slow'))
    items.sort(key=lambda item: (-slow[item.path], item.path))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Choose the wires of a scenario for all of them; DDS is among them if the scenario is marked so."""
    if 'wire' in metafunc.fixturenames:
        also = {DDS} if metafunc.definition.get_closest_marker('also_on_dds') else set()
        metafunc.parametrize('wire', sorted({*TRANSPORTS, *also}), indirect=True)


@pytest.fixture
def wire(request: pytest.FixtureRequest) -> str:
    """One wire, where the test is not marked as different on it."""
    return require_wire(request)


@pytest.fixture
def transport_name(wire: str) -> str:
    """Each transport in turn, by its RMW_IMPLEMENTATION name; folders and modules may choose others."""
    return wire


@pytest.fixture
def isolated(transport_name: str, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """A world of its own for this process; returns the environment, for child processes in the same world."""
    env = isolated_env(transport_name)
    for name in set(os.environ) - set(env):
        monkeypatch.delenv(name)
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    return env


@pytest.fixture
def open_session(isolated: dict[str, str]) -> Iterator[OpenSession]:
    """A function that opens one more session in the isolated world; all are closed after the test."""
    opened: list[Session] = []

    def open_one() -> Session:
        options = SessionOptions(domain_id=int(isolated['ROS_DOMAIN_ID']))
        opened.append(registry.get(isolated['RMW_IMPLEMENTATION']).open(options))
        return opened[-1]

    yield open_one
    for session in opened:
        session.close()


@pytest.fixture
def session_pair(open_session: OpenSession) -> tuple[Session, Session]:
    """Two sessions that see each other."""
    return open_session(), open_session()
