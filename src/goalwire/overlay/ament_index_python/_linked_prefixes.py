"""Prefixes made of links, for packages that are not laid out as colcon installs them.

ros2 run, ros2 pkg executables and launch_ros look for <prefix>/lib/<package>/<executable>, and many programs
for <prefix>/share/<package>. pip puts a package's programs into the environment's bin/; a package in a
workspace, or one named by an entry point, is not in a prefix at all. Such a package gets its own prefix: a
folder of links in the user's cache. The folder's name is a hash of the link targets, so its links are never
out of date, and several processes may make the folder at once.
"""

from __future__ import annotations

import contextlib
import os
import re
import site
import sys
import sysconfig
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.files import cache_folder
from goalwire.idl.entry_points import GROUP

if TYPE_CHECKING:
    from importlib.metadata import Distribution

_MARKERS = 'share/ament_index/resource_index/packages'


def of_pip() -> list[str]:
    """Return the folders into which pip installs data files: the environment's, and the user's if enabled."""
    folders = [sys.prefix, sysconfig.get_path('data', vars={'base': sys.prefix})]
    if site.ENABLE_USER_SITE:
        folders.append(site.getuserbase())
    return list(dict.fromkeys(folders))


def with_programs(package: str, prefix: str) -> str:
    """Return a prefix for a package from pip's `prefix`, with lib/<package> if the package has programs."""
    if Path(prefix, 'lib', package).is_dir():
        return prefix
    programs = _programs(package)
    share = Path(prefix, 'share', package)
    return (programs and _make(package, share, programs)) or prefix


def around(package: str, share: str, *, of_distribution: bool) -> str:
    """Return a prefix, made of links, for a package whose files are in `share` itself.

    If pip installed the package (`of_distribution`), the prefix has links to its programs, too. Return
    `share` if links cannot be made.
    """
    return _make(package, Path(share), _programs(package) if of_distribution else []) or share


def around_source(package: str, source: str, metadata: str) -> str:
    """Return a prefix, with all scripts, for a package that pip installed editable from `source`."""
    from importlib.metadata import Distribution

    return _make(package, Path(source), _scripts(Distribution.at(metadata))) or source


def _programs(package: str) -> list[Path]:
    """Return the scripts of the distribution that pip installed the package from, sorted.

    A distribution may have several packages. A script whose module is in another package of the distribution
    is left out.
    """
    from importlib.metadata import distributions

    for distribution in distributions():
        record = distribution.read_text('RECORD') or ''
        others = {
            *re.findall(f'{_MARKERS}/([^,/]+),', record),
            *distribution.entry_points.select(group=GROUP).names,
        }
        if package not in others:
            continue
        others.remove(package)
        modules = {
            script.name: script.value.partition(':')[0].partition('.')[0]
            for script in distribution.entry_points.select(group='console_scripts')
        }
        return [file for file in _scripts(distribution) if modules.get(file.stem) not in others]
    return []


def _scripts(distribution: Distribution) -> list[Path]:
    """Return the files of a distribution that are in the environment's bin/ or Scripts/, sorted."""
    record = distribution.read_text('RECORD') or ''
    names = [row.rpartition(',')[0].rpartition(',')[0].strip('"') for row in record.splitlines()]
    files = [Path(os.path.normpath(str(distribution.locate_file(name)))) for name in names]
    return sorted(file for file in files if file.parent.name in ('bin', 'Scripts') and file.is_file())


def _make(package: str, share: Path, programs: list[Path]) -> str | None:
    """Return a prefix with links to these files; None if links cannot be made."""
    from hashlib import sha256

    names = '\0'.join(map(str, [share, *programs]))
    digest = sha256(os.fsencode(names)).hexdigest()[:16]
    links = {f'share/{package}': share, **{f'lib/{package}/{file.name}': file for file in programs}}
    try:
        prefix = Path(cache_folder('prefixes')) / f'{package}-{digest}'
        for name, target in links.items():
            _link(prefix / name, target)
    except OSError:  # the cache cannot be written, links are not supported, or the user has no home
        return None
    return str(prefix)


def _link(place: Path, target: Path) -> None:
    if not place.is_symlink():
        place.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):  # another process has made the link
            place.symlink_to(target, target_is_directory=target.is_dir())
