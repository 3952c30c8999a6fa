"""The pytest plugin in a project of somebody else's."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

TESTS = """
import time

import pytest
from std_srvs.srv import SetBool


def test_a_graph(gw_graph, request):
    gw_graph.service(SetBool, 'set', SetBool.Response(success=True))
    assert gw_graph.call(SetBool, 'set', timeout=20.0).success
    assert gw_graph.transport == request.config.getoption('--gw-transport')


def test_time(gw_graph, gw_clock):
    gw_graph.service(SetBool, 'set')
    before = time.monotonic()
    time.sleep(1000.0)
    assert time.monotonic() - before == gw_clock.elapsed == 1000.0


def test_deadlock(gw_clock):
    import threading

    threading.Event().wait()


def test_leak(gw_graph):
    import rclpy

    rclpy.init(args=[])
"""


def _pytest(folder: Path, *arguments: str) -> str:
    run = subprocess.run(
        [sys.executable, '-W', 'error', '-m', 'pytest', '-p', 'no:cacheprovider', *arguments, str(folder)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=100.0,
    )
    return run.stdout + run.stderr


def test_the_fixtures_are_there_wherever_goalwire_is_installed_in_parallel_too(tmp_path: Path) -> None:
    (tmp_path / 'test_mine.py').write_text(TESTS)
    output = _pytest(tmp_path, '-rA', '-n', '2')
    assert 'PASSED test_mine.py::test_a_graph' in output
    assert 'PASSED test_mine.py::test_time' in output
    assert 'FAILED test_mine.py::test_deadlock' in output
    assert 'DeadlockError: everything waits and nothing is due' in output
    assert 'ERROR test_mine.py::test_leak - AssertionError: rclpy was initialised and not' in output


def test_a_run_on_zenoh_leaves_out_what_needs_virtual_time(tmp_path: Path) -> None:
    (tmp_path / 'test_mine.py').write_text(TESTS)
    output = _pytest(tmp_path, '-rA', '--gw-transport=zenoh', '-k', 'graph or time')
    assert 'PASSED test_mine.py::test_a_graph' in output
    assert 'SKIPPED [1] ' in output
    assert 'virtual time needs the transport memory, and this run is on zenoh' in output


def test_a_project_that_does_not_use_it_does_not_load_it(tmp_path: Path) -> None:
    (tmp_path / 'test_mine.py').write_text(
        'def test_modules():\n'
        '    import sys\n'
        "    loaded = {name for name in sys.modules if name.startswith('goalwire.')}\n"
        "    assert 'goalwire.testing.plugin' in loaded\n"
        "    loaded = {name for name in loaded if not name.startswith('goalwire.idl')}\n"
        "    plugins = {f'goalwire.testing.{name}' for name in ('plugin', 'launch_tests')}\n"
        "    assert loaded == {'goalwire.testing', *plugins}, loaded\n"
        "    assert not {'numpy', 'rclpy', 'asyncio', 'yaml'} & {*sys.modules} - {'asyncio'}\n"
    )
    output = _pytest(tmp_path, '-p', 'no:xdist', '-p', 'no:timeout', '-p', 'no:anyio')
    assert '1 passed' in output
    assert 'warning' not in output
