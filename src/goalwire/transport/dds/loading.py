"""The one loaded library of this process: found, looked over once, refused where it does not fit."""

from __future__ import annotations

from threading import Lock

from goalwire.errors import ForkedError, TransportError
from goalwire.transport.dds.abi import Library
from goalwire.transport.dds.library import INSTALLING, OVERRIDE, find_library
from goalwire.transport.dds.selftest import find_fault
from goalwire.transport.endpoint import ForkGuard

_lock = Lock()
_loaded: list[tuple[Library, ForkGuard]] = []


def load() -> Library:
    """Return the library.

    Raises TransportError where there is none or it does not fit, ForkedError in a child whose parent uses it.
    """
    with _lock:
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
    if fault:
        raise TransportError(
            f"the Cyclone DDS library '{path}' cannot be used ({fault}): install the "
            f'right one with {INSTALLING}, or let {OVERRIDE} name another'
        )
    return library
