"""launch_testing.test_runner: runs launches, tests beside their processes, and tests after their end."""

from __future__ import annotations

import inspect
import threading
import unittest
from collections.abc import Sequence
from typing import Any

from launch import LaunchDescription, LaunchDescriptionSource, LaunchService
from launch.actions import IncludeLaunchDescription, RegisterEventHandler
from launch.event_handlers import OnProcessExit, OnProcessIO, OnProcessStart

from launch_testing.io_handler import ActiveIoHandler
from launch_testing.loader import ENTRY, TestRun
from launch_testing.proc_info_handler import ActiveProcInfoHandler
from launch_testing.test_result import FailResult, Result, SkipResult, TestResult

__all__ = ['LaunchTestRunner']


class LaunchDiedError(Exception):
    """An error if a launch ended before its tests did."""


class _Launch:
    """One test run: the launch in the calling thread, which gets signals; its tests in another thread."""

    def __init__(
        self, run: TestRun, preamble: Sequence[Any], arguments: Sequence[str], *, debug: bool
    ) -> None:
        self._run = run
        self._preamble = list(preamble)
        self._arguments = _split_arguments(arguments)
        self._service = LaunchService(debug=debug)
        self._info = ActiveProcInfoHandler()
        self._output = ActiveIoHandler()
        self._is_ready = threading.Event()
        self._results: TestResult | None = None
        self._failure: BaseException | None = None

    def run(self) -> TestResult:
        """Return the results of all tests. Raises LaunchDiedError."""
        description, context = self._run.normalized_test_description(ready_fn=self._is_ready.set)
        self._bind(context)
        self._service.include_launch_description(self._around(description))
        tester = threading.Thread(target=self._test_beside, name='test_runner_thread', daemon=True)
        tester.start()
        self._service.run(shutdown_when_idle=not self._run.markers.get('keep_alive', False))
        has_ended_early = self._results is None and self._failure is None
        self._is_ready.set()
        if has_ended_early:
            print('Processes under test stopped before tests completed')
            self._print_failed()
            raise LaunchDiedError
        tester.join()
        if self._results is None:
            raise LaunchDiedError from self._failure
        self._results.append(_run_suite(self._run.post_shutdown_tests))
        return self._results

    def _bind(self, context: dict[str, Any]) -> None:
        common = {**context, **self._run.param_args}
        beside = {
            'proc_info': self._info,
            'proc_output': self._output,
            'test_args': dict(self._arguments),
            'launch_service': self._service,
        }
        after = {
            'proc_info': self._info._proc_info_handler,
            'proc_output': self._output._io_handler,
            'test_args': dict(self._arguments),
        }
        self._run.bind(self._run.pre_shutdown_tests, beside, {**common, **beside})
        self._run.bind(self._run.post_shutdown_tests, after, {**common, **after})

    def _around(self, description: LaunchDescription) -> LaunchDescription:
        """Return the launch description with handlers that record the output and ends of its processes."""
        handlers = [
            OnProcessStart(on_start=lambda info, _: self._info.append(info)),
            OnProcessStart(on_start=lambda info, _: self._output.track(info.process_name)),
            OnProcessExit(on_exit=lambda info, _: self._info.append(info)),
            OnProcessIO(on_stdout=self._output.append, on_stderr=self._output.append),
        ]
        source = LaunchDescriptionSource(launch_description=description)
        included = IncludeLaunchDescription(source, launch_arguments=self._arguments)
        return LaunchDescription([*self._preamble, *map(RegisterEventHandler, handlers), included])

    def _test_beside(self) -> None:
        try:
            if not self._is_ready.wait(self._run.timeout):
                print('Timed out waiting for processes to start up')
                return
            self._results = _run_suite(self._run.pre_shutdown_tests)
        except BaseException as error:
            self._failure = error
        finally:
            self._service.shutdown()

    def _print_failed(self) -> None:
        """Print the output of processes that ended with an error."""
        for info in self._info:
            code = getattr(info, 'returncode', None)
            if not code:
                continue
            print(f"Process '{info.process_name}' exited with {code}")
            print(f"##### '{info.process_name}' output #####")
            for io in self._output[info.process_name]:
                print(io.text.decode(errors='replace'))


class LaunchTestRunner:
    """Runs each launch with its tests."""

    def __init__(
        self, test_runs: Sequence[TestRun], launch_file_arguments: Sequence[str] = (), debug: bool = False
    ) -> None:
        self._test_runs = test_runs
        self._launch_file_arguments = launch_file_arguments
        self._debug = debug

    def generate_preamble(self) -> list[Any]:
        """Return actions to carry out before each launch description.

        Derived runners override this method.
        """
        return []

    def run(self) -> dict[TestRun, Result]:
        """Run all launches with their tests, and return each run's results.

        Stop after a launch that ends too early.
        """
        results: dict[TestRun, Result] = {}
        for run in self._test_runs:
            if len(self._test_runs) > 1:
                print(f'\nStarting test run {run}')
            try:
                launch = _Launch(
                    run, self.generate_preamble(), self._launch_file_arguments, debug=self._debug
                )
                results[run] = launch.run()
            except unittest.SkipTest as skip:
                print(f'{run} is skipped: {skip}')
                results[run] = SkipResult(run, str(skip))
            except LaunchDiedError:
                results[run] = FailResult(run, 'Launch stopped before the active tests finished.')
                break
        return results

    def validate(self) -> None:
        """Raise Exception if a description function's arguments differ from the names of its parameters."""
        for run in self._test_runs:
            function = inspect.unwrap(run._test_description_function)
            taken = list(inspect.signature(function).parameters)
            for name in run.param_args:
                if name not in taken:
                    raise Exception(  # noqa: TRY002 - what launch_testing raises
                        f'Could not find an argument in {ENTRY} matching '
                        f"prametrized argument '{name}'"  # launch_testing's spelling
                    )
            for name in taken:
                if name not in run.param_args:
                    raise Exception(  # noqa: TRY002
                        f"{ENTRY} has unexpected extra argument '{name}'"
                    )


def _run_suite(tests: unittest.TestSuite) -> TestResult:
    result: TestResult = unittest.TextTestRunner(verbosity=2, resultclass=TestResult).run(tests)  # type: ignore[assignment]
    return result


def _split_arguments(arguments: Sequence[str]) -> list[tuple[str, str]]:
    """Return names and values of arguments NAME:=VALUE; the last value of a name counts.

    Raises RuntimeError.
    """
    found: dict[str, str] = {}
    for argument in arguments:
        name, separator, value = argument.partition(':=')
        if not name or not separator:
            raise RuntimeError(f"malformed launch argument '{argument}', expected format '<name>:=<value>'")
        found[name] = value
    return list(found.items())
