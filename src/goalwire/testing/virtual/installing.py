"""Replaces Python's clocks, sleeps and locks in the loaded modules by stand-ins, and restores them."""

from __future__ import annotations

import sys
from types import ModuleType

from goalwire.testing.virtual.stand_ins import ATTRIBUTES, NAMES

_WAITING = frozenset({'_thread', 'queue', 'threading', 'time'})
"""Modules of the standard library that get the stand-ins: the other modules are built on these."""

_RUNNERS = frozenset({'_pytest', 'execnet', 'hypothesis', 'pluggy', 'pytest', 'pytest_timeout', 'xdist'})

_clean: dict[str, tuple[ModuleType, int]] = {}
"""Modules in which no name had to be replaced, and the number of their names when they were searched."""


class Installation:
    """Replaces the real functions by the stand-ins; `remove` restores the real functions."""

    def __init__(self) -> None:
        self._undo: list[tuple[object, str, object]] = []
        for owner, name, stand_in in ATTRIBUTES:
            self._put(owner, name, stand_in)
        for module_name, module in list(sys.modules.items()):
            if _wants(module_name, module) and not _is_clean(module_name, module):
                self._put_into(module_name, module)

    def _put_into(self, module_name: str, module: ModuleType) -> None:
        space = vars(module)
        found = [name for name, value in list(space.items()) if id(value) in NAMES]
        for name in found:
            self._put(module, name, NAMES[id(space[name])])
        if not found:
            _clean[module_name] = module, len(space)

    def _put(self, owner: object, name: str, stand_in: object) -> None:
        self._undo.append((owner, name, getattr(owner, name)))
        setattr(owner, name, stand_in)

    def remove(self) -> None:
        """Restore the real functions."""
        while self._undo:
            owner, name, real = self._undo.pop()
            setattr(owner, name, real)


def _wants(module_name: str, module: object) -> bool:
    if not isinstance(module, ModuleType) or module_name.startswith('goalwire.testing.virtual.'):
        return False
    top = module_name.partition('.')[0]
    return top not in _RUNNERS and (module_name in _WAITING or top not in sys.stdlib_module_names)


def _is_clean(module_name: str, module: ModuleType) -> bool:
    return _clean.get(module_name) == (module, len(vars(module)))
