"""The measured subjects: goalwire on its own sessions, eclipse-zenoh's and libddsc; rclpy; raw wires."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from helpers import real_rclpy
from helpers.environments import CannotInstall

from benchmarks import ROOT, spinning
from benchmarks.line import Line
from goalwire.errors import TransportError
from goalwire.transport import dds
from goalwire.transport.dds.cyclone.library import find_library

Program: TypeAlias = Callable[[Line], list[str]]
"""The module that does a line's work, and its first arguments; empty if the subject has no such program."""

UNCHANGED: Mapping[str, str] = MappingProxyType({})
NATIVE = {'GOALWIRE_ZENOH': 'native'}
ECLIPSE_ENV = {'GOALWIRE_ZENOH': 'eclipse'}
NO_LOOK = {'GOALWIRE_LOOK_US': '0'}
"""Nobody looks at the wire before a sleep."""


class Subject(NamedTuple):
    """Somebody who does the work of a line, in two processes; `env` comes on top of a clean environment."""

    name: str
    transport: str
    program: Program
    env: Mapping[str, str] = UNCHANGED
    python: Path = Path(sys.executable)

    def command(self, line: Line, *arguments: object) -> list[str]:
        """Return what measures a line; empty where this subject does no such work."""
        program = self.program(line)
        return [str(self.python), '-m', *program, *map(str, arguments)] if program else []


def own_program(line: Line) -> list[str]:
    """Every line's program."""
    return [line.module, 'ask']


def peer_program(line: Line) -> list[str]:
    """The same program, where rclpy can do that."""
    return own_program(line) if line.peer else []


def spinning_program(line: Line) -> list[str]:
    """The same program, where another executor changes something."""
    return peer_program(line) if line.spins else []


def looking_program(line: Line) -> list[str]:
    """The same program, where a look before a sleep changes something."""
    return own_program(line) if line.looks else []


def floor(module: str) -> Program:
    """A raw wire's program, which does every work that has a floor."""
    return lambda line: [module, 'ask', line.floor] if line.floor else []


ZENOH = Subject('goalwire on Zenoh', 'rmw_zenoh_cpp', own_program, NATIVE)
ZENOH_NO_LOOK = Subject('goalwire on Zenoh, no look', 'rmw_zenoh_cpp', looking_program, {**NATIVE, **NO_LOOK})
ECLIPSE = Subject("goalwire on eclipse-zenoh's session", 'rmw_zenoh_cpp', own_program, ECLIPSE_ENV)
EVENTS = {spinning.EXECUTOR: 'rclpy.experimental:EventsExecutor'}
MULTI = {spinning.EXECUTOR: 'rclpy.executors:MultiThreadedExecutor'}
ZENOH_EVENTS = Subject(
    'goalwire on Zenoh, EventsExecutor', 'rmw_zenoh_cpp', spinning_program, {**NATIVE, **EVENTS}
)
ZENOH_MULTI = Subject(
    'goalwire on Zenoh, MultiThreadedExecutor', 'rmw_zenoh_cpp', spinning_program, {**NATIVE, **MULTI}
)
DDS = Subject('goalwire on DDS', 'rmw_cyclonedds_cpp', own_program, {dds.CHOICE: dds.NATIVE})
DDS_LIBRARY = Subject('goalwire on libddsc', 'rmw_cyclonedds_cpp', own_program, {dds.CHOICE: dds.CYCLONE})
RAW_NATIVE = Subject('its session alone', 'rmw_zenoh_cpp', floor('benchmarks.floors.native'))
RAW_NATIVE_NO_LOOK = RAW_NATIVE._replace(name='its session alone, no look', env=NO_LOOK)
RAW_ECLIPSE = Subject('eclipse-zenoh alone', 'rmw_zenoh_cpp', floor('benchmarks.floors.zenoh'))
RAW_DDS = Subject('libddsc alone', 'rmw_cyclonedds_cpp', floor('benchmarks.floors.dds'))
TCP = Subject('Python on TCP', 'rmw_zenoh_cpp', floor('benchmarks.floors.tcp'))
PEER = 'rclpy on Fast DDS'
PEER_EVENTS = 'rclpy on Fast DDS, EventsExecutor'
PEERS = (PEER, PEER_EVENTS)
"""The real rclpy, by the executor that spins."""
REFERENCE = 'reference: rclpy on Cyclone DDS'
"""Measured earlier; every line holds its figures."""

RAW = {
    ZENOH.name: RAW_NATIVE.name,
    ZENOH_NO_LOOK.name: RAW_NATIVE_NO_LOOK.name,
    ECLIPSE.name: RAW_ECLIPSE.name,
    DDS.name: RAW_DDS.name,
    DDS_LIBRARY.name: RAW_DDS.name,
}
"""The wire that each goalwire is held against: with the same settings."""


def has_dds() -> bool:
    """Whether the library of DDS is here; not every platform has a wheel of it."""
    try:
        find_library()
    except TransportError:
        return False
    return True


def everybody(*, with_peers: bool = True) -> tuple[list[Subject], str]:
    """Return all subjects that can be had here, and why the real rclpy is not among them."""
    subjects = [
        ZENOH, RAW_NATIVE, ZENOH_NO_LOOK, RAW_NATIVE_NO_LOOK, TCP, ECLIPSE, RAW_ECLIPSE, DDS, DDS_LIBRARY,
        RAW_DDS, ZENOH_EVENTS, ZENOH_MULTI,
    ]  # fmt: skip
    if not with_peers:
        return subjects, 'nobody asked for it'
    if not real_rclpy.EXISTS:
        return subjects, real_rclpy.WHY_NOT
    try:
        environment = real_rclpy.kept(ROOT / 'build', real_rclpy.NEWEST)
    except CannotInstall as error:
        return subjects, f'the real rclpy could not be installed: {error}'
    python, env = environment.python.absolute(), {spinning.SPIN_ONCE: '1'}
    peer = Subject(PEER, 'rmw_fastrtps_cpp', peer_program, env, python)
    events = Subject(PEER_EVENTS, 'rmw_fastrtps_cpp', spinning_program, {**env, **EVENTS}, python)
    return [*subjects, peer, events], ''
