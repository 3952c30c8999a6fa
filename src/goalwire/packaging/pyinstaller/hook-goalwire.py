"""PyInstaller's hook: the library, the definitions that come along, and those of the workspace of the build.

goalwire imports most of its modules when they are first needed, so PyInstaller sees few of them by itself.
"""

from pathlib import Path

from PyInstaller.utils.hooks import collect_data_files, collect_submodules

from goalwire.idl import search_path
from goalwire.idl.stubs import own_packages

_NOT_NEEDED = ('goalwire.apps', 'goalwire.testing', 'goalwire.packaging')

hiddenimports = collect_submodules('goalwire', filter=lambda name: not name.startswith(_NOT_NEEDED))
datas = collect_data_files('goalwire', subdir=str(Path('idl', 'share')))
for name in own_packages():
    found = search_path.find_package(name)
    if found is not None:
        datas += [
            (str(file), str(Path('goalwire', 'idl', 'share', name, file.parent.name)))
            for file in found.files().values()
        ]
