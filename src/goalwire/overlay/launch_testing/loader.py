"""launch_testing.loader: finds the launches that a test file describes, and the tests of each launch."""

from __future__ import annotations

import functools
import inspect
import unittest
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import ModuleType
from typing import Any

from launch import LaunchDescription

from launch_testing.actions import ReadyToTest
from launch_testing.decorator import TIMEOUT

__all__ = ['LoadTestsFromPythonModule', 'PostShutdownTestLoader', 'PreShutdownTestLoader', 'TestRun']

READY_WITHIN = 15.0  # in s
ENTRY = 'generate_test_description'


class TestRun:
    """One launch: the tests that run beside its processes, and the tests after the processes' end."""

    __test__ = False  # without this attribute pytest would collect the class as a test

    def __init__(
        self,
        name: str,
        test_description_function: Callable[..., Any],
        param_args: Mapping[str, Any],
        pre_shutdown_tests: unittest.TestSuite,
        post_shutdown_tests: unittest.TestSuite,
    ) -> None:
        self.name = name
        self.param_args = dict(param_args)
        self.pre_shutdown_tests = pre_shutdown_tests
        self.post_shutdown_tests = post_shutdown_tests
        self._test_description_function = test_description_function
        self.timeout: float = getattr(test_description_function, TIMEOUT, READY_WITHIN)
        """How many seconds the launch may take until ReadyToTest."""
        if self.param_args:
            for case in self.all_cases():
                self._rename(case)
        for suite in (*_suites(pre_shutdown_tests), *_suites(post_shutdown_tests)):
            suite._removeTestAtIndex = lambda _index: None  # type: ignore[attr-defined]

    @property
    def markers(self) -> dict[str, Any]:
        """The markers that `launch_testing.markers` has put on the description."""
        return dict(getattr(self._test_description_function, '__markers__', {}))

    def normalized_test_description(
        self, *, ready_fn: Callable[[], object]
    ) -> tuple[LaunchDescription, dict[str, Any]]:
        """Return the launch description and the values for tests.

        Raises Exception if there is no ReadyToTest action.
        """
        made = self._test_description_function()
        description, context = made if isinstance(made, tuple) else (made, {})
        ready = next(_ready_actions(description.entities), None)
        if ready is None:
            raise Exception(  # noqa: TRY002 - what launch_testing raises
                f'{ENTRY} functions must return a LaunchDescription containing a ReadyToTest action'
            )
        ready._add_callback(ready_fn)
        return description, context

    def bind(
        self,
        tests: unittest.TestSuite,
        injected_attributes: Mapping[str, Any] | None = None,
        injected_args: Mapping[str, Any] | None = None,
    ) -> None:
        """Give tests their values: as arguments, chosen by name, or as attributes, which are deprecated."""
        for cls in {type(case): None for case in _cases(tests)}:
            for name, value in (injected_attributes or {}).items():
                setattr(cls, name, _warning_property(name, value))
            for method in ('setUpClass', 'tearDownClass'):
                setattr(cls, method, _bind(getattr(cls, method), injected_args or {}))
        for case in _cases(tests):
            for method in (case._testMethodName, 'setUp', 'tearDown'):
                setattr(case, method, _bind(getattr(case, method), injected_args or {}))

    def get_launch_description(self) -> LaunchDescription:
        """Return the launch description only for reading: it cannot be launched."""
        return self.normalized_test_description(ready_fn=lambda: None)[0]

    def all_cases(self) -> Iterator[unittest.TestCase]:
        """Yield every test."""
        yield from _cases(self.pre_shutdown_tests)
        yield from _cases(self.post_shutdown_tests)

    def __str__(self) -> str:
        return self.name + self._parameters()

    def _parameters(self) -> str:
        return f'[{", ".join(map(str, self.param_args.values()))}]' if self.param_args else ''

    def _rename(self, case: unittest.TestCase) -> None:
        method = getattr(case, case._testMethodName)
        case._testMethodName += self._parameters()
        setattr(case, case._testMethodName, method)


def LoadTestsFromPythonModule(module: ModuleType, *, name: str = 'launch_tests') -> list[TestRun]:
    """Return a TestRun for each launch that the module describes."""
    entry = getattr(module, ENTRY)
    descriptions = entry() if hasattr(entry, '__parametrized__') else [(entry, {})]
    return [
        TestRun(
            name,
            description,
            arguments,
            PreShutdownTestLoader().loadTestsFromModule(module),
            PostShutdownTestLoader().loadTestsFromModule(module),
        )
        for description, arguments in descriptions
    ]


def PreShutdownTestLoader() -> unittest.TestLoader:
    """Return a loader for the tests that run beside the processes."""
    return _Loader(is_post_shutdown=False)


def PostShutdownTestLoader() -> unittest.TestLoader:
    """Return a loader for the tests that run after all processes have ended."""
    return _Loader(is_post_shutdown=True)


class _Loader(unittest.TestLoader):
    def __init__(self, *, is_post_shutdown: bool) -> None:
        super().__init__()
        self._is_post_shutdown = is_post_shutdown

    def loadTestsFromTestCase(self, testCaseClass: type[unittest.TestCase]) -> unittest.TestSuite:
        if getattr(testCaseClass, '__post_shutdown_test__', False) != self._is_post_shutdown:
            return unittest.TestSuite()
        # Each launch has its own subclass, since `bind` sets the launch's values on the class.
        own = type(testCaseClass.__name__, (testCaseClass,), {'__module__': testCaseClass.__module__})
        return super().loadTestsFromTestCase(own)


def _ready_actions(entities: Iterable[Any]) -> Iterator[ReadyToTest]:
    for entity in entities:
        if isinstance(entity, ReadyToTest):
            yield entity
        yield from _ready_actions(entity.describe_sub_entities())
        for _, inner in entity.describe_conditional_sub_entities():
            yield from _ready_actions(inner)


def _bind(function: Callable[..., Any], given: Mapping[str, Any]) -> Callable[..., Any]:
    wanted = inspect.signature(function).parameters
    return functools.partial(function, **{name: value for name, value in given.items() if name in wanted})


def _warning_property(name: str, value: Any) -> property:
    def read(self: unittest.TestCase) -> Any:
        warnings.warn(
            f'Automatically adding attributes like self.{name} to the test class is deprecated: '
            f'add {name} to the arguments of the test',
            stacklevel=2,
        )
        return value

    return property(read)


def _suites(tests: Any) -> Iterator[unittest.TestSuite]:
    if isinstance(tests, unittest.TestSuite):
        yield tests
        for inner in tests:
            yield from _suites(inner)


def _cases(tests: Any) -> Iterator[unittest.TestCase]:
    if isinstance(tests, unittest.TestSuite):
        for inner in tests:
            yield from _cases(inner)
    elif tests is not None:
        yield tests
