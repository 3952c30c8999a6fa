"""Warns of arguments on the command line that no launch file uses, such as `spede:=2` for `speed`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

from goalwire.errors import LaunchError
from goalwire.files import read_regular
from goalwire.launching.model import LaunchDescription, LaunchDescriptionEntity
from goalwire.launching.sources import (
    LARGEST,
    PYTHON_ENDINGS,
    IncludeLaunchDescription,
    get_launch_description_from_any_launch_file,
)

OF_LAUNCH = frozenset(
    {'emulate_tty', 'launch-prefix', 'launch-prefix-filter', 'sigkill_timeout', 'sigterm_timeout'}
)
"""The launch configurations that launch itself reads."""
_DEEPEST = 20


def unknown_arguments(path: str, names: Iterable[str]) -> list[str]:
    """Return a warning for each name that is neither in an XML or YAML file nor in its includes.

    A Python file can create names while it runs: if any of the files is in Python, or unreadable, return [].
    """
    wanted = [name for name in names if name not in OF_LAUNCH]
    if not wanted or path.endswith(PYTHON_ENDINGS):
        return []
    try:
        description = get_launch_description_from_any_launch_file(path)
        texts = _texts(path, description, 0)
        if texts is None:
            return []
        known = [argument.name for argument in description.get_launch_arguments()]
    except (LaunchError, OSError):
        return []  # the launch itself reports the error in the file
    words = {word for text in texts for word in re.findall(r'[\w.-]+', text)}
    return [_sentence(name, known) for name in wanted if name not in words]


def _sentence(name: str, known: list[str]) -> str:
    near = get_close_matches(name, known, n=1)
    if near:
        hint = f'did you mean {near[0]}?'
    else:
        hint = f'it takes {", ".join(known)}' if known else 'it takes no arguments'
    return f"the launch file has no argument '{name}'; {hint}"


def _texts(path: str, description: LaunchDescription, depth: int) -> list[str] | None:
    """Return the texts of a file and of its includes; None if one of these is in Python, or unreadable."""
    text = read_regular(path, LARGEST).decode(errors='replace')
    if 'def generate_launch_description' in text:
        return None
    found = [text]
    for include in _includes(description.entities):
        source = include.launch_description_source
        if source.location.rstrip("'").endswith(PYTHON_ENDINGS) or depth >= _DEEPEST:
            return None  # a Python file is not run only to check names
        inner = include.read_ahead()
        more = None if inner is None else _texts(source.location, inner, depth + 1)
        if more is None:
            return None
        found += more
    return found


def _includes(entities: Iterable[LaunchDescriptionEntity]) -> list[IncludeLaunchDescription]:
    found: list[IncludeLaunchDescription] = []
    for entity in entities:
        if isinstance(entity, IncludeLaunchDescription):
            found.append(entity)
            continue
        found += _includes(entity.describe_sub_entities())
        for _, inner in entity.describe_conditional_sub_entities():
            found += _includes(inner)
    return found
