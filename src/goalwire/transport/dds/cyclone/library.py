"""Finds libddsc, loads it once per process, and tests that its layouts are those of abi.py.

The places are, in this order: an override, the `cyclonedds` wheel, a ROS 2 installation, the system. Only the
shared library of the wheel is used; nothing of its Python package is imported. The test sends three messages
from a writer to a reader in a domain of their own, which sends nothing to the network. A library that fails
is refused.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from glob import escape, glob
from threading import Lock

from goalwire.concurrency.forks import ForkGuard
from goalwire.errors import ForkedError, GoalwireError, TransportError
from goalwire.rules.qos import QoS
from goalwire.transport.dds.cyclone.abi import Library
from goalwire.transport.dds.cyclone.qos import endpoint_qos, read_qos, read_user_data
from goalwire.transport.dds.cyclone.wire import Participant, Reader, Writer
from goalwire.transport.loopback import ADVICE, is_loopback_down

OVERRIDE = 'GOALWIRE_LIBDDSC'
"""The variable that names the library file; it has precedence over all other places."""

INSTALLING = "pip install 'cyclonedds==11.0.*'"
"""The command that installs the same wheel as goalwire[dds]."""

_PATTERNS = {
    'linux': ('cyclonedds.libs/libddsc-*.so*',),
    'darwin': ('cyclonedds/.dylibs/libddsc*.dylib', 'cyclonedds.libs/libddsc*.dylib'),
    'win32': ('cyclonedds.libs/ddsc*.dll', 'cyclonedds/.libs/ddsc*.dll'),
}


def find_library() -> str:
    """Return the path or name of libddsc. Raises TransportError with advice on what to install."""
    override = os.environ.get(OVERRIDE, '').strip()
    if override:
        if not os.path.isfile(override):  # noqa: PTH113 - pathlib takes 5 ms to import
            raise TransportError(f"{OVERRIDE} is '{override}', and there is no such file: correct it")
        return override
    for path in _candidates():
        return path
    from ctypes.util import find_library as find_of_system

    found = find_of_system('ddsc')
    if found is None:
        raise TransportError(f'RMW_IMPLEMENTATION=rmw_cyclonedds_cpp needs Cyclone DDS: {_advice()}')
    return found


def _candidates() -> Iterator[str]:
    yield from _of_wheel()
    distribution = os.environ.get('ROS_DISTRO', '').strip()
    if distribution:
        lib = escape(f'/opt/ros/{distribution}/lib')
        yield from sorted(glob(f'{lib}/libddsc.so*'))  # noqa: PTH207
        yield from sorted(glob(f'{lib}/*/libddsc.so*'))  # noqa: PTH207


def _of_wheel() -> list[str]:
    from importlib.util import find_spec

    spec = find_spec('cyclonedds')
    places = [] if spec is None else list(spec.submodule_search_locations or ())
    patterns = _PATTERNS.get(sys.platform, ())
    folders = [escape(os.path.dirname(place)) for place in places]  # noqa: PTH120
    return [path for folder in folders for pattern in patterns for path in glob(f'{folder}/{pattern}')]  # noqa: PTH207


def _advice() -> str:
    import platform

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


_SELFTEST_DOMAIN = 100
_SELFTEST = (
    b'<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
    b'<AllowMulticast>false</AllowMulticast></General><Discovery>'
    b'<ParticipantIndex>none</ParticipantIndex><Tag>goalwire_selftest</Tag></Discovery></Domain></CycloneDDS>'
)
_MESSAGES = (b'\0\1\0\0\7', b'\0\1\0\0self', b'\0\1\0\0' + bytes(range(250)))
_USER_DATA = b'typehash=none;'
_CLOCK_NS = 60_000_000_000


def find_fault(library: Library) -> str:
    """Return the fault of a library, '' if it has none."""
    domain = library.dds_create_domain(_SELFTEST_DOMAIN, _SELFTEST)
    if domain < 0:
        return 'it cannot create a domain'
    try:
        return _exchange(library)
    except GoalwireError as error:
        return str(error)
    finally:
        library.dds_delete(domain)


def _exchange(library: Library) -> str:
    participant = Participant(library, _SELFTEST_DOMAIN, b'')
    asked = QoS(depth=len(_MESSAGES))
    with endpoint_qos(library, asked, _USER_DATA) as qos:
        if read_user_data(library, qos) != _USER_DATA or read_qos(library, qos) != asked.stated():
            return 'its QoS is laid out differently'
        reader = Reader(participant, 'rt/selftest', 'goalwire::msg::dds_::SelfTest_', qos)
        writer = Writer(participant, 'rt/selftest', 'goalwire::msg::dds_::SelfTest_', qos)
    if any(writer.write(message) for message in _MESSAGES):
        return 'it does not write serialized messages'
    _, taken = reader.take()
    if [each.payload[: len(sent)] for each, sent in zip(taken, _MESSAGES, strict=False)] != list(_MESSAGES):
        return 'messages do not come back as they were sent'
    if any(each.publication != writer.instance for each in taken):
        return 'messages do not tell their publisher'
    if any(abs(each.source_timestamp - time.time_ns()) > _CLOCK_NS for each in taken):
        return 'messages do not tell their time'
    return ''


_loading = Lock()
_loaded: list[tuple[Library, ForkGuard]] = []


def load() -> Library:
    """Load and return the library.

    Raises TransportError if there is none or it does not fit, ForkedError in a child whose parent uses it.
    """
    with _loading:
        if not _loaded:
            _loaded.append((_fitting(find_library()), ForkGuard()))
        library, guard = _loaded[0]
    if guard.is_forked:
        raise ForkedError(
            'this process was forked from one that uses DDS, which cannot be started again in such a child; '
            "start it with subprocess or multiprocessing's spawn method, or fork first"
        )
    return library


def _fitting(path: str) -> Library:
    try:
        library = Library(path)
        fault = find_fault(library)
    except (OSError, AttributeError) as error:
        fault = str(error)
    if fault and is_loopback_down():
        raise TransportError(f'Cyclone DDS cannot be tried out: {ADVICE}')
    if fault:
        raise TransportError(
            f"the Cyclone DDS library '{path}' cannot be used ({fault}): install the "
            f'right one with {INSTALLING}, or let {OVERRIDE} name another'
        )
    return library
