"""Who is measured: goalwire on both wires, the real rclpy, and the raw wires without either."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from helpers import real_rclpy
from helpers.environments import CannotInstall

from benchmarks import ROOT, stage
from benchmarks.line import Line
from goalwire.errors import TransportError
from goalwire.transport.dds.library import find_library

Program: TypeAlias = Callable[[Line], list[str]]
"""The module that does a line's work, and its first arguments; empty where there is none."""

UNCHANGED: Mapping[str, str] = MappingProxyType({})
AS_IT_COMES = {'ZENOH_RUNTIME': '()', 'GOALWIRE_PIN_THREADS': '0'}
"""Zenoh's own thread pools, and a new Python thread state for every callback."""


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


def floor(module: str, *works: str) -> Program:
    """A raw wire's program for the works that it does."""
    return lambda line: [module, 'ask', line.floor] if line.floor in works else []


_WORKS = ('service', 'topic', 'asyncio', 'throughput', 'image')
ZENOH = Subject('goalwire on Zenoh', 'rmw_zenoh_cpp', own_program)
DDS = Subject('goalwire on DDS', 'rmw_cyclonedds_cpp', own_program)
RAW_ZENOH = Subject('raw Zenoh', 'rmw_zenoh_cpp', floor('benchmarks.floors.zenoh', *_WORKS))
UNTUNED_ZENOH = RAW_ZENOH._replace(name='raw Zenoh as it comes', env=AS_IT_COMES)
RAW_DDS = Subject('raw DDS', 'rmw_cyclonedds_cpp', floor('benchmarks.floors.dds', *_WORKS))
TCP = Subject('TCP in Python', 'rmw_zenoh_cpp', floor('benchmarks.floors.tcp', 'service'))
PEER = 'rclpy on Fast DDS'

RAW = {ZENOH.name: RAW_ZENOH.name, DDS.name: RAW_DDS.name}
"""The wire that each goalwire is held against: with the same settings."""


def has_dds() -> bool:
    """Whether the library of DDS is here; not every platform has a wheel of it."""
    try:
        find_library()
    except TransportError:
        return False
    return True


def everybody(*, peer: bool = True) -> tuple[list[Subject], str]:
    """Return all subjects that can be had here, and why the real rclpy is not among them."""
    subjects = [ZENOH, RAW_ZENOH, DDS, RAW_DDS, UNTUNED_ZENOH, TCP]
    if not peer:
        return subjects, 'nobody asked for it'
    if not real_rclpy.EXISTS:
        return subjects, real_rclpy.WHY_NOT
    try:
        environment = real_rclpy.kept(ROOT / 'build')
    except CannotInstall as error:
        return subjects, f'the real rclpy could not be installed: {error}'
    python, env = environment.python.absolute(), {stage.SPIN_ONCE: '1'}
    return [*subjects, Subject(PEER, 'rmw_fastrtps_cpp', peer_program, env, python)], ''
