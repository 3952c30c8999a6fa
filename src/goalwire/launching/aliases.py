"""Makes modules with one class each, for imports such as `launch.substitutions.launch_configuration`.

ROS 2's packages have a module for each class. In goalwire, classes of one kind share a module; `add_modules`
registers a module under each of ROS 2's names, with its class in it.
"""

from __future__ import annotations

import re
import sys
from types import ModuleType

_made: dict[str, ModuleType] = {}


def add_modules(package: str, exceptions: dict[str, str] | None = None) -> None:
    """Register a module for each class in the package's __all__.

    A module's name is its class's name in snake case, or the name that `exceptions` has for the class.
    """
    module = sys.modules[package]
    for name in module.__all__:
        own = (exceptions or {}).get(name) or re.sub(
            r'(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])', '_', name
        ).lower()
        full = f'{package}.{own}'
        alias = _made.get(full)
        if alias is None:
            if full in sys.modules or hasattr(module, own):
                continue
            alias = _made[full] = sys.modules[full] = ModuleType(full, f'{full}: {name}.')
            setattr(module, own, alias)
        setattr(alias, name, getattr(module, name))
