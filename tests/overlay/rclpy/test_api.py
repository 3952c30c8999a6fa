"""Every public name of ROS 2 Jazzy's rclpy stands, and takes the parameters that programs pass by name."""

from __future__ import annotations

import enum
import importlib
import inspect
import re
from collections.abc import Iterator
from types import ModuleType
from typing import NamedTuple

import pytest
from helpers.environments import ROOT

_LINE = re.compile(r'(?P<name>[\w.]+)(?:\((?P<parameters>.*)\))?')


class Wanted(NamedTuple):
    """A name below its module, and parameters by which it is called."""

    name: str
    parameters: tuple[str, ...]


def _read() -> dict[str, list[Wanted]]:
    modules: dict[str, list[Wanted]] = {}
    for line in (ROOT / 'tests' / 'data' / 'rclpy_api.txt').read_text(encoding='utf-8').splitlines():
        if line.startswith('['):
            names = modules.setdefault(line.strip('[]'), [])
        elif found := _LINE.fullmatch(line):
            names.append(Wanted(found['name'], tuple(filter(None, (found['parameters'] or '').split(', ')))))
    return modules


API = _read()


def missing(module: ModuleType, wanted: Wanted) -> Iterator[str]:
    """Yield what `module` lacks of a name."""
    owner: object = module
    *path, last = wanted.name.split('.')
    for name in path:
        owner = getattr(owner, name, None)
    if not _has(owner, last):
        yield wanted.name
        return
    if not wanted.parameters:
        return
    try:
        taken = inspect.signature(getattr(owner, last)).parameters
    except ValueError:  # made in C: an exception's __init__, say
        return
    if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in taken.values()):
        yield from (f'{wanted.name}({name})' for name in wanted.parameters if name not in taken)


def _has(owner: object, name: str) -> bool:
    if isinstance(owner, type) and not issubclass(owner, enum.Enum):
        return inspect.getattr_static(owner, name, None) is not None or name in inspect.get_annotations(owner)
    return hasattr(owner, name)


def test_the_list_is_whole() -> None:
    assert len(API) > 50
    assert sum(map(len, API.values())) > 680
    assert Wanted('Node.destroy_node', ()) in API['rclpy.node']
    assert Wanted('spin_once', ('node', 'executor', 'timeout_sec')) in API['rclpy']


@pytest.mark.parametrize('module', API)
def test_the_names_of_a_module_stand(module: str) -> None:
    work_queue = importlib.import_module(module)
    assert [what for wanted in API[module] for what in missing(work_queue, wanted)] == []


def test_what_is_missing_is_found() -> None:
    work_queue = importlib.import_module('rclpy.node')
    assert list(missing(work_queue, Wanted('Nod', ()))) == ['Nod']
    assert list(missing(work_queue, Wanted('Node.nope', ()))) == ['Node.nope']
    assert list(missing(work_queue, Wanted('Node.create_timer', ('callback', 'nope')))) == [
        'Node.create_timer(nope)'
    ]
