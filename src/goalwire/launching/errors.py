"""Turns errors in launch files into errors of one sentence each, with the file and line."""

from __future__ import annotations

import inspect
import re
import traceback
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from goalwire.errors import BadLaunchValueError, LaunchError
from goalwire.files import show


class Location(NamedTuple):
    """A line of a launch file."""

    file: str
    line: int

    def __str__(self) -> str:
        return f'{show(self.file)}:{self.line}'


_launch_files: set[str] = set()


def remember_launch_file(path: str) -> None:
    """Register a Python file as a launch file, so that errors inside it are reported with its line."""
    _launch_files.add(path)


def locate(error: Exception, location: Location | None, prefix: str = '') -> LaunchError:
    """Return the error with file and line in front: the launch file's line that raised it, or `location`."""
    if isinstance(error, LaunchError) and error.located:
        return error
    place = _line_of_launch_file(error) or location
    text = prefix + as_sentence(error)
    kind = BadLaunchValueError if isinstance(error, BadLaunchValueError) else LaunchError
    told = kind(f'{place}: {text}' if place else text, located=place is not None)
    told.__cause__ = error
    return told


def _explain_indentation(error: IndentationError) -> str:
    """Return a hint about an IndentationError: which indentations the lines above allow."""
    try:
        with open(error.filename or '', encoding='utf-8') as file:
            lines = file.read().splitlines()[: error.lineno or 0]
    except OSError:
        return ''
    blanks = [len(line) - len(line.lstrip(' ')) for line in lines if line.strip()]
    if not blanks:
        return ''
    above = sorted({each for each in blanks[:-1] if each <= max(blanks[-3:-1], default=0)})
    allowed = ' or '.join(map(str, above))
    return f'; the line has {blanks[-1]} blanks before it, those above have {allowed}: give it one of these'


def as_sentence(error: BaseException) -> str:
    """Return an error's message on one line, with its type in front if the message needs it."""
    text = ' '.join((error.msg if isinstance(error, SyntaxError) else str(error)).split())
    if isinstance(error, IndentationError) and text.startswith('unindent'):
        text += _explain_indentation(error)
    if isinstance(error, LaunchError) and text:
        return text
    if isinstance(error, OSError) and error.strerror:
        where = f' {show(str(error.filename))}' if error.filename else ''
        return f'{error.strerror}:{where}' if where else error.strerror
    if isinstance(error, TypeError) and (told := _unknown_keyword(error, text)):
        return told
    if type(error).__name__ == 'PackageNotFoundError':
        return text
    return f'{type(error).__name__}: {text}' if text else type(error).__name__


def _unknown_keyword(error: TypeError, text: str) -> str | None:
    """Return a message for an unknown keyword argument, with a similar name; None for other errors.

    Python's message names the base class whose __init__ failed; the frames show the constructed class.
    """
    match = re.fullmatch(r"(\w+)\.__init__\(\) got an unexpected keyword argument '(\w+)'.*", text)
    if match is None:
        return None
    made = [
        type(frame.f_locals['self'])
        for frame, _ in traceback.walk_tb(error.__traceback__)
        if frame.f_code.co_name == '__init__' and 'self' in frame.f_locals
    ]
    if not made:
        return None
    known = {
        name
        for base in made[0].__mro__
        if '__init__' in vars(base) and base is not object
        for name in inspect.signature(vars(base)['__init__']).parameters
    } - {'self', 'options'}
    near = get_close_matches(match[2], sorted(known), n=1)
    hint = f'; did you mean {near[0]}?' if near else ''
    return f"{made[0].__name__} does not take '{match[2]}'{hint}"


def _line_of_launch_file(error: Exception) -> Location | None:
    if isinstance(error, SyntaxError) and error.filename in _launch_files and error.lineno:
        return Location(str(error.filename), error.lineno)
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if frame.filename in _launch_files and frame.lineno:
            return Location(frame.filename, frame.lineno)
    return None


HERE = str(Path(__file__).parent)
OVERLAY = str(Path(__file__).parent.parent / 'overlay')
