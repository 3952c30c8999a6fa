"""The real rclpy of PyPI in an environment of its own, and programs run under it and under goalwire."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NoReturn

import pytest
from helpers import real_rclpy
from helpers.environments import CannotInstall, Environment, kept_for_all
from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.programs import server_of_programs
from helpers.traces import Outcome, Trace, read_trace

FOLDER = Path(__file__).parent
NOT_CHECKED = pytest.StashKey[str]()


@pytest.fixture(scope='session')
def real(pytestconfig: pytest.Config) -> Environment:
    """An environment with the real rclpy, kept between test runs; skips the test if it cannot be had."""
    if not real_rclpy.EXISTS:
        _skip(pytestconfig, real_rclpy.WHY_NOT)
    try:
        return kept_for_all(pytestconfig.cache, *real_rclpy.WHEELS)
    except CannotInstall as error:
        if not error.unreachable:
            raise
        _skip(pytestconfig, f'PyPI cannot be reached: {error}')


def _skip(config: pytest.Config, reason: str) -> NoReturn:
    config.stash[NOT_CHECKED] = reason
    pytest.skip(reason)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say in plain words that nothing was compared, where that is so."""
    if reason := config.stash.get(NOT_CHECKED, None):
        terminalreporter.section('goalwire was NOT compared with the real rclpy', red=True)
        terminalreporter.line(reason)


@pytest.fixture
def trace(real: Environment, tmp_path: Path) -> Trace:
    """A function that runs a program of `programs/` under both at once: goalwire's trace, the real one's."""

    def run_both(name: str) -> tuple[list[Outcome], list[Outcome]]:
        ours = _start(
            name,
            isolated_env('rmw_zenoh_cpp', tmp_path),
            Path(sys.executable),
            tmp_path / 'ours',
            server_of_programs(),
        )
        theirs = _start(
            name,
            isolated_env('rmw_fastrtps_cpp', tmp_path) | {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'},
            real.python,
            tmp_path / 'real',
        )
        with ours, theirs:
            return _finish(ours, tmp_path / 'ours'), _finish(theirs, tmp_path / 'real')

    return run_both


def _start(
    name: str, env: dict[str, str], python: Path, trace: Path, server: ForkServer | None = None
) -> Program:
    tracer, program = FOLDER / 'tracer.py', FOLDER / 'programs' / f'{name}.py'
    return Program(
        tracer,
        str(program),
        str(trace),
        env=env | {'RCUTILS_COLORIZED_OUTPUT': '0'},
        python=python,
        server=server,
    )


def _finish(program: Program, trace: Path) -> list[Outcome]:
    program.succeed(60)
    return read_trace(trace.read_text(encoding='utf-8'))
