"""Launch tests under pytest: a file whose `generate_test_description` is marked is one test.

The marks are `launch_test`, and `rostest` of launch_testing_ros, which means the same.

If ROS 2's own launch_testing is installed, its plugin does the work, and goalwire's plugin does nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

MARKS = ('launch_test', 'rostest')


def is_ours() -> bool:
    """Return whether the importable `launch_testing` is goalwire's: ROS 2's has its own pytest plugin."""
    from importlib.util import find_spec

    found = find_spec('launch_testing')
    return found is not None and 'goalwire' in Path(found.origin or '').parts


def pytest_addoption(parser: pytest.Parser) -> None:
    if is_ours():
        parser.addoption('--launch-args', action='append', nargs='*', default=[], help='NAME:=VALUE')


def pytest_configure(config: pytest.Config) -> None:
    for mark in MARKS:
        config.addinivalue_line('markers', f'{mark}: marks generate_test_description as a launch test')


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module | None:
    """Collect the file if its text has one of the marks; leave all other files to pytest."""
    try:
        text = module_path.read_text(encoding='utf-8', errors='replace')
    except OSError:
        return None
    if not any(f'mark.{mark}' in text for mark in MARKS) or not is_ours():
        return None
    module: pytest.Module = LaunchTestModule.from_parent(parent, path=module_path)
    return module


class LaunchTestFailure(Exception):
    """Tests of a launch failed; the text has the message of each."""


class LaunchTestModule(pytest.Module):
    """A file with a launch test, or an ordinary file in which only the mark's name occurs."""

    def collect(self) -> Iterator[pytest.Item | pytest.Collector]:
        entry = getattr(self.obj, 'generate_test_description', None)
        marks = getattr(entry, 'pytestmark', [])
        if not any(mark.name in MARKS for mark in marks):
            yield from super().collect()
            return
        for mark in marks:
            self.add_marker(getattr(pytest.mark, mark.name).with_args(*mark.args, **mark.kwargs))
        yield LaunchTestItem.from_parent(self, name=self.obj.__name__)


class LaunchTestItem(pytest.Item):
    """All launches of a file, with their tests."""

    def runtest(self) -> None:
        from launch_testing.loader import LoadTestsFromPythonModule
        from launch_testing.test_runner import LaunchTestRunner

        parent: Any = self.parent
        arguments = [word for words in self.config.getoption('--launch-args') for word in words]
        runner = LaunchTestRunner(LoadTestsFromPythonModule(parent.obj, name=self.name), arguments)
        runner.validate()
        results = runner.run().values()
        if not all(result.wasSuccessful() for result in results):
            told = [pair for result in results for pair in (*result.errors, *result.failures)]
            raise LaunchTestFailure('\n\n'.join(f'{case}\n{text}' for case, text in told))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        if isinstance(excinfo.value, LaunchTestFailure):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        return self.path, None, f'launch tests: {self.name}'
