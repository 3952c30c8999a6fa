"""The environment's variables that say how sessions are opened: rmw_zenoh's own, and three of goalwire's.

    ZENOH_SESSION_CONFIG_URI, ZENOH_ROUTER_CONFIG_URI   a json5 file in place of the built-in settings
    ZENOH_CONFIG_OVERRIDE                               `key/path=json5;…` on top of either
    ZENOH_SHM_ALLOC_SIZE, ZENOH_SHM_MESSAGE_SIZE_THRESHOLD   bytes; sizes of shared memory, if it is on
    GOALWIRE_SHARED_MEMORY                              on, off: whether goalwire's own programs share memory
    ZENOH_ROUTER_CHECK_ATTEMPTS                         how many seconds to look for a router before a warning
    GOALWIRE_ZENOH                                      native, eclipse: who opens sessions and rendezvous
    GOALWIRE_ROUTER                                     auto, on, off: whether to offer a rendezvous
    GOALWIRE_ROUTER_PORT                                where it is offered and looked for (7447)

The first two are read in `reader`. Source: rmw_zenoh_cpp src/detail/zenoh_config.cpp, zenoh_utils.cpp.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

from goalwire.errors import TransportError
from goalwire.transport.zenoh.settings.values import Settings
from goalwire.zenoh.io.endpoints import as_port

DEFAULT_PORT = 7447
CHOICE = 'GOALWIRE_ZENOH'
NATIVE, ECLIPSE = 'native', 'eclipse'
INSTALL_ECLIPSE = "pip install 'goalwire[eclipse]'"
"""The command that installs eclipse-zenoh, for errors."""
START_ROUTER = 'start one (ros2 router; beside an installed ROS 2 also ros2 run rmw_zenoh_cpp rmw_zenohd)'
"""The advice if no router answers."""


def advise_unreached(mode: str) -> str:
    """Return advice for a session that reaches nobody at its addresses; a client needs a router there."""
    check = 'check ZENOH_SESSION_CONFIG_URI, ZENOH_CONFIG_OVERRIDE and that these addresses can be reached'
    return f'{START_ROUTER}, or {check}' if mode == 'client' else check


def zenoh_choice(env: Mapping[str, str] = os.environ) -> str:
    """Return who opens sessions, NATIVE or ECLIPSE; raises TransportError for another value."""
    chosen = env.get(CHOICE) or NATIVE
    if chosen not in {NATIVE, ECLIPSE}:
        raise TransportError(f"{CHOICE} is '{chosen}'; set it to {NATIVE} or {ECLIPSE}")
    return chosen


class RendezvousChoice(Enum):
    """The choice to offer a rendezvous or not. AUTO decides by the machine and the configuration."""

    AUTO = 'auto'
    ON = 'on'
    OFF = 'off'


class Override(NamedTuple):
    """One pair of ZENOH_CONFIG_OVERRIDE: a slash-separated path and a json5 text."""

    path: str
    value: str


def router_port(env: Mapping[str, str] = os.environ) -> int:
    """Return the rendezvous port; raises TransportError if it is not a port."""
    text = env.get('GOALWIRE_ROUTER_PORT') or str(DEFAULT_PORT)
    port = as_port(text)
    if not port:
        raise TransportError(f"GOALWIRE_ROUTER_PORT is '{text}'; set it to a port number from 1 to 65535")
    return port


def rendezvous_choice(env: Mapping[str, str] = os.environ) -> RendezvousChoice:
    """Return the value of GOALWIRE_ROUTER; auto means off if rmw_zenoh, and so its router, is installed."""
    text = env.get('GOALWIRE_ROUTER') or 'auto'
    try:
        choice = RendezvousChoice(text)
    except ValueError:
        raise TransportError(f"GOALWIRE_ROUTER is '{text}'; set it to auto, on or off") from None
    if choice is RendezvousChoice.AUTO and _has_rmw_zenoh(env.get('AMENT_PREFIX_PATH', '')):
        return RendezvousChoice.OFF
    return choice


def _has_rmw_zenoh(prefixes: str) -> bool:
    """Return whether an ament prefix has rmw_zenoh. A workspace without ROS 2 has prefixes but no router."""
    return any(
        os.path.exists(f'{prefix}/share/ament_index/resource_index/packages/rmw_zenoh_cpp')  # noqa: PTH110
        for prefix in prefixes.split(os.pathsep)
        if prefix
    )


def overrides(env: Mapping[str, str] = os.environ) -> tuple[list[Override], list[str]]:
    """Return the pairs of ZENOH_CONFIG_OVERRIDE, and the parts of it that are not pairs."""
    pairs, broken = [], []
    for part in filter(None, (part.strip() for part in env.get('ZENOH_CONFIG_OVERRIDE', '').split(';'))):
        path, found, value = (text.strip() for text in part.partition('='))
        if path and found and value:
            pairs.append(Override(path, value))
        else:
            broken.append(part)
    return pairs, broken


def shared_memory(env: Mapping[str, str] = os.environ) -> Settings:
    """Return the requested shared memory sizes by zenoh's names; raises TransportError for a bad size."""
    sizes: Settings = {}
    if text := env.get('ZENOH_SHM_ALLOC_SIZE'):
        sizes['pool_size'] = _size('ZENOH_SHM_ALLOC_SIZE', text)
    if text := env.get('ZENOH_SHM_MESSAGE_SIZE_THRESHOLD'):
        threshold = _size('ZENOH_SHM_MESSAGE_SIZE_THRESHOLD', text)
        if threshold & (threshold - 1):
            raise TransportError(f'ZENOH_SHM_MESSAGE_SIZE_THRESHOLD is {text}; set it to a power of 2')
        sizes['message_size_threshold'] = threshold
    return sizes


def shares_memory(env: Mapping[str, str] = os.environ) -> bool:
    """Return whether goalwire's own programs share memory, whatever Zenoh's settings say about others."""
    text = env.get('GOALWIRE_SHARED_MEMORY') or 'on'
    if text not in {'on', 'off'}:
        raise TransportError(f"GOALWIRE_SHARED_MEMORY is '{text}'; set it to on or off")
    return text == 'on'


def _size(name: str, text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise TransportError(f"{name} is '{text}'; set it to a number of bytes above 0")
    return int(text)


def router_check_seconds(env: Mapping[str, str] = os.environ) -> float | None:
    """Return how long to look for a router: None if not at all, infinity if for ever.

    rmw checks n times, a second apart; so n attempts look for n - 1 seconds.
    """
    text = env.get('ZENOH_ROUTER_CHECK_ATTEMPTS') or '1'
    try:
        attempts = int(text)
    except ValueError:
        raise TransportError(
            f"ZENOH_ROUTER_CHECK_ATTEMPTS is '{text}'; set it to a whole number (0: for ever, -1: no check)"
        ) from None
    if attempts < 0:
        return None
    return attempts - 1.0 if attempts else float('inf')
