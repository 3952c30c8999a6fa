"""Lets launch files and components import the Python modules of source packages.

`from nav2_common.launch import RewrittenYaml` finds `nav2_common/` in the source package of that name, if no
installed module has the name: this finder is the last on sys.meta_path.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

from goalwire.launching.packages import use_source


class SourceModules:
    """Finds the module of a source package that has the package's name."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a top-level module, None if no source package has it."""
        folder = use_source(fullname) if path is None else None
        if folder is None:
            return None
        return PathFinder.find_spec(fullname, [folder, os.path.join(folder, 'src')], target)


def offer_source_modules() -> None:
    """Let this process import the modules of source packages. Later calls do nothing."""
    if not any(isinstance(finder, SourceModules) for finder in sys.meta_path):
        sys.meta_path.append(SourceModules())
