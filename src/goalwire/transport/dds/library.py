"""Where libddsc comes from: an override, the `cyclonedds` wheel, a ROS 2 installation, the system.

Only the shared library of the wheel is used; nothing of its Python package is imported.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from pathlib import Path

from goalwire.errors import TransportError

OVERRIDE = 'GOALWIRE_LIBDDSC'
"""Names the library file to use, before all others."""

INSTALLING = "pip install 'cyclonedds==11.0.*'"
"""What goalwire[dds] installs, too."""

_PATTERNS = {
    'linux': ('cyclonedds.libs/libddsc-*.so*',),
    'darwin': ('cyclonedds/.dylibs/libddsc*.dylib', 'cyclonedds.libs/libddsc*.dylib'),
    'win32': ('cyclonedds.libs/ddsc*.dll', 'cyclonedds/.libs/ddsc*.dll'),
}


def find_library() -> str:
    """Return the path or name of libddsc. Raises TransportError, which says what to install."""
    override = os.environ.get(OVERRIDE, '').strip()
    if override:
        if not Path(override).is_file():
            raise TransportError(f"{OVERRIDE} is '{override}', and there is no such file: correct it")
        return override
    for path in _candidates():
        return str(path)
    from ctypes.util import find_library as find_of_system

    found = find_of_system('ddsc')
    if found is None:
        raise TransportError(f'RMW_IMPLEMENTATION=rmw_cyclonedds_cpp needs Cyclone DDS: {_advice()}')
    return found


def _candidates() -> Iterator[Path]:
    yield from _of_wheel()
    distribution = os.environ.get('ROS_DISTRO', '').strip()
    if distribution:
        lib = Path('/opt/ros') / distribution / 'lib'
        yield from sorted(lib.glob('libddsc.so*'))
        yield from sorted(lib.glob('*/libddsc.so*'))


def _of_wheel() -> list[Path]:
    from importlib.util import find_spec

    spec = find_spec('cyclonedds')
    places = [] if spec is None else list(spec.submodule_search_locations or ())
    patterns = _PATTERNS.get(sys.platform, ())
    return [path for state in places for pattern in patterns for path in Path(state).parent.glob(pattern)]


def _advice() -> str:
    machine, version = platform.machine().lower(), sys.version_info
    if sys.platform == 'linux' and machine not in {'x86_64', 'amd64'}:
        why = f'its wheels do not cover Linux on {machine}'
    elif version >= (3, 14):
        why = f'its wheels do not cover Python {version.major}.{version.minor}'
    else:
        return f'install it with: {INSTALLING}'
    return (
        f'{why}; install libddsc from your system or a ROS 2 (ros-<distribution>-cyclonedds, with ROS_DISTRO '
        f'set), or let {OVERRIDE} name the library file'
    )
