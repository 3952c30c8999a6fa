"""Prefixes made of links, for packages that lie otherwise than colcon would lay them.

ros2 run, ros2 pkg executables and launch_ros look for <prefix>/lib/<package>/<executable>, and many programs
for <prefix>/share/<package>. pip puts a package's programs into the environment's bin/, and the package of a
workspace or of an entry point has no prefix around it. Such a package gets a prefix of its own, as colcon can
make them: a folder of links in the user's cache. It is named after what it links to, so it is never wrong,
and several processes may fill it at once.
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
    """The folders that pip puts data files into: of the environment, and of the user where that is on."""
    folders = [sys.prefix, sysconfig.get_path('data', vars={'base': sys.prefix})]
    if site.ENABLE_USER_SITE:
        folders.append(site.getuserbase())
    return list(dict.fromkeys(folders))


def with_programs(package: str, prefix: str) -> str:
    """The prefix of a package that pip installed into `prefix`: with lib/<package>, if it has programs."""
    if Path(prefix, 'lib', package).is_dir():
        return prefix
    programs = _programs(package)
    share = Path(prefix, 'share', package)
    return (programs and _make(package, share, programs)) or prefix


def around(package: str, share: str, *, of_distribution: bool) -> str:
    """The prefix of a package whose files are in the folder `share`, not in <prefix>/share/<package>.

    `of_distribution`: pip installed it, so it may have programs. The prefix is `share` itself where no links
    can be made.
    """
    return _make(package, Path(share), _programs(package) if of_distribution else []) or share


def around_source(package: str, source: str, metadata: str) -> str:
    """The prefix of a package that pip installed editable from a source folder, with all its scripts."""
    from importlib.metadata import Distribution

    return _make(package, Path(source), _scripts(Distribution.at(metadata))) or source


def _programs(package: str) -> list[Path]:
    """The scripts of the distribution that pip installed the package from, sorted.

    A distribution may hold several packages: a script whose module is one of them belongs to that one alone.
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
    """The files of a distribution that lie among the programs of the environment, sorted."""
    record = distribution.read_text('RECORD') or ''
    names = [row.rpartition(',')[0].rpartition(',')[0].strip('"') for row in record.splitlines()]
    files = [Path(os.path.normpath(str(distribution.locate_file(name)))) for name in names]
    return sorted(file for file in files if file.parent.name in ('bin', 'Scripts') and file.is_file())


def _make(package: str, share: Path, programs: list[Path]) -> str | None:
    """A prefix with links to these files; None where none can be made."""
    from hashlib import sha256

    names = '\0'.join(map(str, [share, *programs]))
    digest = sha256(os.fsencode(names)).hexdigest()[:16]
    links = {f'share/{package}': share, **{f'lib/{package}/{file.name}': file for file in programs}}
    try:
        prefix = Path(cache_folder('prefixes')) / f'{package}-{digest}'
        for name, target in links.items():
            _link(prefix / name, target)
    except OSError:  # nowhere to write, no links on this system, or no home
        return None
    return str(prefix)


def _link(place: Path, target: Path) -> None:
    if not place.is_symlink():
        place.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):  # another process was faster
            place.symlink_to(target, target_is_directory=target.is_dir())
