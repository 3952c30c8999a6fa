"""Writes type stubs of the user's own packages when jedi imports a package.

pylsp, vim, IPython and Jupyter use jedi. jedi runs no code of a package, but looks for stubs on the package's
`__path__`. So `__path__` contains a folder in the user's cache, to which stubs are written. The import hook
uses this module, so nothing heavy is imported at the top.
"""

import os
import sys

from goalwire.files import cache_folder
from goalwire.idl import workspace

TYPE_CHECKING = False  # importing typing would take 5 ms
if TYPE_CHECKING:
    from goalwire.idl.search_path import InterfacePackage

EDITORS_LIBRARY = 'jedi'


def prepare(package: 'InterfacePackage') -> str:
    """Return the folder for a package's stubs, '' without a cache; write stubs if this process runs jedi."""
    try:
        cache = cache_folder('stubs')
    except OSError:
        return ''
    place = os.path.splitdrive(package.folder)[1].strip(
        os.sep
    )  # packages of the same name in different places need different folders
    folder = os.path.join(cache, place, package.name)
    if EDITORS_LIBRARY in sys.modules and _is_stale(package, folder):
        _write(package, os.path.dirname(folder))
    return folder


def _is_stale(package: 'InterfacePackage', folder: str) -> bool:
    """Return True if a definition was added, removed or changed after the stubs were written."""
    try:
        written = os.stat(os.path.join(folder, '__init__.pyi')).st_mtime
    except OSError:
        return True
    for kind in workspace.KINDS:
        inside = os.path.join(package.folder, kind)
        names = workspace.definition_names(package.folder, kind)
        files = [inside, *(os.path.join(inside, f'{name}.{kind}') for name in names)]
        for file in files:
            try:
                if os.stat(file).st_mtime > written:
                    return True
            except OSError:  # the folder was removed, or the package has no such folder
                continue
    return False


def _write(package: 'InterfacePackage', folder: str) -> None:
    from pathlib import Path

    from goalwire.idl import stubs

    try:
        stubs.write_stubs(Path(folder), [package.name], broken=[])
    except OSError:  # without stubs the editor completes less, but the import succeeds
        return
