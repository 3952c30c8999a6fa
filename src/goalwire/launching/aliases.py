"""One module a class, for programs that import `launch.substitutions.launch_configuration` and the like.

ROS 2's packages have a module for each class. Here classes of one kind share a module; this registers the
modules of ROS 2 beside it, each with its class.
"""

from __future__ import annotations

import re
import sys
from types import ModuleType

_made: dict[str, ModuleType] = {}


def add_modules(package: str, exceptions: dict[str, str] | None = None) -> None:
    """Register `package.snake_case` for each name in the package's __all__, with some `exceptions`."""
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
