"""launch_testing.test_result: test results that also record the time that each test took."""

from __future__ import annotations

import time
import unittest
from collections.abc import Iterable
from typing import Any, Protocol

__all__ = ['FailResult', 'Result', 'SkipResult', 'TestResult']


class HasCases(Protocol):
    """A test run that can list its tests."""

    def all_cases(self) -> Iterable[unittest.TestCase]:
        """Yield every test."""


class Result(Protocol):
    """The interface that all kinds of results of a run share."""

    testsRun: int
    failures: list[tuple[unittest.TestCase, str]]
    errors: list[tuple[unittest.TestCase, str]]
    skipped: list[tuple[unittest.TestCase, str]]

    @property
    def testTimes(self) -> dict[Any, float]:
        """Return how long each test took, in s."""

    def wasSuccessful(self) -> bool:
        """Return whether all tests passed."""


class FailResult(unittest.TestResult):
    """The result if all tests failed because the launch ended before the tests."""

    def __init__(self, test_run: HasCases, message: str) -> None:
        super().__init__()
        self.testTimes: dict[Any, float] = {}
        for case in test_run.all_cases():
            self.failures.append((case, f'{message}\n'))
            self.testTimes[case] = 0.0
            self.testsRun += 1

    def wasSuccessful(self) -> bool:
        return False


class SkipResult(unittest.TestResult):
    """The result if all tests were skipped because the launch description was skipped."""

    def __init__(self, test_run: HasCases, skip_reason: str = '') -> None:
        super().__init__()
        self.testTimes: dict[Any, float] = {}
        for case in test_run.all_cases():
            self.addSkip(case, skip_reason)
            self.testTimes[case] = 0.0
            self.testsRun += 1


class TestResult(unittest.TextTestResult):
    """A unittest result that also records how long each test took."""

    __test__ = False  # without this attribute pytest would collect the class as a test

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.testTimes: dict[Any, float] = {}
        """The duration of each test, in s."""
        self._began = 0.0

    @property
    def testCases(self) -> list[Any]:
        return list(self.testTimes)

    def startTest(self, test: unittest.TestCase) -> None:
        self._began = time.monotonic()
        super().startTest(test)

    def stopTest(self, test: unittest.TestCase) -> None:
        self.testTimes[test] = time.monotonic() - self._began
        super().stopTest(test)

    def append(self, results: TestResult) -> None:
        """Add the results of other tests of the same run."""
        self.testTimes.update(results.testTimes)
        self.testsRun += results.testsRun
        for name in ('failures', 'errors', 'skipped', 'expectedFailures', 'unexpectedSuccesses'):
            getattr(self, name).extend(getattr(results, name))
