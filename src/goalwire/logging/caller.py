"""Which call in which source file logged: the key of the filters `once`, `skip_first` and `throttle`."""

from __future__ import annotations

import os
import sys
from functools import lru_cache
from types import FrameType
from typing import NamedTuple, Self


class _CallSite(NamedTuple):
    function_name: str
    file_path: str
    line_number: int
    last_index: int
    """The byte code's offset, which tells two calls in one line apart."""


class CallerId(_CallSite):
    """The call site of `frame`, or of whoever constructs it."""

    __slots__ = ()

    def __new__(cls, frame: FrameType | None = None) -> Self:
        frame = frame or sys._getframe(1)  # inspect costs milliseconds to import
        code = frame.f_code
        return super().__new__(cls, code.co_name, _full_path(code.co_filename), frame.f_lineno, frame.f_lasti)


@lru_cache(maxsize=1024)
def _full_path(filename: str) -> str:
    return os.path.abspath(filename)  # noqa: PTH100 - links are left as they are
