"""Finds places in a program's own code, as texts such as 'talker.py:12', which editors make links of.

A warning about a mistake names the wrong line in the program, not the library's line that noticed it.
"""

from __future__ import annotations

import os
import sys
from types import FunctionType, MethodType
from typing import TYPE_CHECKING

from goalwire.tracebacks import is_library, is_standard

if TYPE_CHECKING:
    from types import CodeType, FrameType


def caller_place() -> str:
    """Return the innermost line of the program in the present call stack; '' if the stack has no
    such line.
    """
    frame = program_frame(sys._getframe(1))
    return '' if frame is None else place_of_frame(frame)


def program_frame(frame: FrameType | None) -> FrameType | None:
    """Return `frame`, or the first of its callers that is neither the library's nor Python's own."""
    while frame is not None and _is_foreign(frame.f_code):
        frame = frame.f_back
    return frame


def outermost_program_frame(frame: FrameType | None, below: CodeType) -> FrameType | None:
    """Return the outermost frame of the program between the call of `below` and `frame`; None if there is
    none.
    """
    found = None
    while frame is not None and frame.f_code is not below:
        if not _is_foreign(frame.f_code):
            found = frame
        frame = frame.f_back
    return None if frame is None else found


def place_of_frame(frame: FrameType) -> str:
    """Return the place of the line that a frame executes."""
    return _show(frame.f_code.co_filename, frame.f_lineno)


def source_of_frame(frame: FrameType) -> str:
    """Return the source of the line that a frame executes, without its comment; '' if the file cannot be
    read.
    """
    from linecache import getline  # imported here, since only warnings need it

    return getline(frame.f_code.co_filename, frame.f_lineno).partition('  # ')[0].strip()


def raising_place(error: BaseException) -> str:
    """Return the innermost function and line of the program in a traceback, as 'count() in counter.py:12', or
    ''.
    """
    found, step = '', error.__traceback__
    while step is not None:
        code = step.tb_frame.f_code
        if not _is_foreign(code):
            found = f'{code.co_qualname}() in {_show(code.co_filename, step.tb_lineno)}'
        step = step.tb_next
    return found


def function_place(function: object) -> str:
    """Return the place where a function or method is defined; '' if it is not the program's own."""
    if isinstance(function, MethodType):
        function = function.__func__
    if not isinstance(function, FunctionType) or _is_foreign(function.__code__):
        return ''
    return _show(function.__code__.co_filename, function.__code__.co_firstlineno)


def dropping_place(depth: int = 1) -> str:
    """Return the place of a call of a library function if the calling line drops the result.

    The library function is the caller of `dropping_place` with `depth` 1, that function's caller with 2.
    Returns '' if the line keeps the result, or if the library itself made the call.
    """
    from dis import get_instructions

    frame = sys._getframe(depth).f_back
    if frame is None or _is_foreign(frame.f_code):
        return ''
    following = (each for each in get_instructions(frame.f_code) if each.offset > frame.f_lasti)
    after = next(following, None)
    return place_of_frame(frame) if after is not None and after.opname == 'POP_TOP' else ''


def is_in_constructor(made: object, frame: FrameType) -> bool:
    """Return True if `frame` executes an `__init__` of the object `made`."""
    code = frame.f_code
    return (
        code.co_name == '__init__'
        and code.co_argcount > 0
        and (frame.f_locals.get(code.co_varnames[0]) is made)
    )


def at(place: str) -> str:
    """Return ' (place)', to be appended to a sentence; '' if `place` is ''."""
    return f' ({place})' if place else ''


def _is_foreign(code: CodeType) -> bool:
    return is_library(code.co_filename) or is_standard(code.co_filename)


def _show(filename: str, line: int | None) -> str:
    here = os.getcwd() + os.sep if os.path.isabs(filename) else ''  # noqa: PTH109, PTH117
    return f'{filename.removeprefix(here) if here else filename}:{line}'
