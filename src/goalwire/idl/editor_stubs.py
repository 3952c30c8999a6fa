"""Stubs of packages of one's own, written when jedi asks for a package.

pylsp, vim, IPython and Jupyter use jedi. It runs no code of a package, and looks for stubs on the package's
`__path__`. So that leads to a folder in the user's cache. The import hook uses this module: nothing heavy is
imported at the top.
"""

import os
import sys

from goalwire.files import cache_folder
from goalwire.idl import workspace

TYPE_CHECKING = False  # typing would cost 5 ms
if TYPE_CHECKING:
    from goalwire.idl.search_path import InterfacePackage

EDITORS_LIBRARY = 'jedi'


def prepare(package: 'InterfacePackage') -> str:
    """Return the folder for a package's stubs, '' if there is none; write them if jedi runs here."""
    try:
        cache = cache_folder('stubs')
    except OSError:
        return ''
    place = os.path.splitdrive(package.folder)[1].strip(os.sep)  # packages of one name lie in several folders
    folder = os.path.join(cache, place, package.name)
    if EDITORS_LIBRARY in sys.modules and _is_stale(package, folder):
        _write(package, os.path.dirname(folder))
    return folder


def _is_stale(package: 'InterfacePackage', folder: str) -> bool:
    """Whether a definition came, went or changed after the stubs were written."""
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
            except OSError:  # it is gone again, or this kind was never there
                continue
    return False


def _write(package: 'InterfacePackage', folder: str) -> None:
    from pathlib import Path

    from goalwire.idl import stubs

    try:
        stubs.write_stubs(Path(folder), [package.name], broken=[])
    except OSError:  # nowhere to write: the editor knows less, and the import goes on
        return
