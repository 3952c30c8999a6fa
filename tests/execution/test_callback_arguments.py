"""How many arguments a callback takes."""

from __future__ import annotations

import functools
import inspect
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from goalwire.execution import callback_arguments
from goalwire.execution.callback_arguments import _plain_arguments, accepts


class Robot:
    def one(self, message: object) -> None: ...

    def any(*arguments: object) -> None: ...

    def default(self, message: object = None, info: object = None) -> None: ...

    @classmethod
    def of_class(cls, message: object, info: object) -> None: ...

    @staticmethod
    def static(message: object) -> None: ...

    def __call__(self, message: object) -> None: ...


def decorated(message: object) -> None: ...


@functools.wraps(decorated)
def decorator(*arguments: object) -> None:
    decorated(*arguments)


CALLABLES: list[Callable[..., object]] = [
    lambda: None,
    lambda message: None,
    lambda message, /: None,
    lambda message, info: None,
    lambda message, info, more: None,
    lambda message, info=None, more=None: None,
    lambda *arguments: None,
    lambda message, *arguments: None,
    lambda message, info, more, *arguments: None,
    lambda message, **named: None,
    lambda message, *, named: None,
    lambda message, *, named=1: None,
    lambda message, info=None, *, named=1: None,
    decorator,
    Robot.one,
    Robot().one,
    Robot().any,
    Robot().default,
    Robot.of_class,
    Robot.static,
    Robot().static,
    Robot(),
    functools.partial(decorated, 1),
    [].append,
    [].insert,
    Robot,
]


@pytest.mark.parametrize('callback', CALLABLES)
@pytest.mark.parametrize('count', [0, 1, 2, 3])
def test_a_callback_takes_what_inspect_says_it_does(callback: Callable[..., object], count: int) -> None:
    try:
        inspect.signature(callback).bind(*range(count))
    except TypeError:
        assert not accepts(callback, count)
    else:
        assert accepts(callback, count)


@pytest.mark.parametrize('callback', [decorated, lambda message, info: None, Robot().one, Robot.of_class])
def test_functions_and_methods_are_judged_without_inspect(callback: Callable[..., object]) -> None:
    assert _plain_arguments(callback) is not None


def test_what_a_callback_takes_is_found_out_in_one_file_alone() -> None:
    folder = Path(callback_arguments.__file__).parents[1]
    readers = {
        file.relative_to(folder).as_posix()
        for file in folder.rglob('*.py')
        if 'inspect import signature' in file.read_text(encoding='utf-8')
    }
    assert readers == {'execution/callback_arguments.py'}


def test_what_runs_a_coroutine_is_imported_before_its_first_call() -> None:
    program = """
        import sys
        from goalwire.execution.callback_arguments import import_coroutine_runner

        class Arm:
            async def move(self, goal): ...
            def stop(self, goal): ...

        import_coroutine_runner(Arm().stop)
        print('asyncio' in sys.modules)
        import_coroutine_runner(Arm().move)
        print('asyncio' in sys.modules)
    """
    done = subprocess.run(
        [sys.executable, '-c', textwrap.dedent(program)], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ['False', 'True']
