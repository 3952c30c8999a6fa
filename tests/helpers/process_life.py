"""Worlds for the programs of tests/process_life, on each wire, eclipse-zenoh's sessions among them."""

from __future__ import annotations

from pathlib import Path

from helpers.isolation import isolated_env
from helpers.wires import DDS, require

from goalwire.transport.zenoh.settings.environment import CHOICE, ECLIPSE, NATIVE

PROGRAMS = Path(__file__).parents[1] / 'process_life' / 'programs'

WIRES = {
    'zenoh': {'RMW_IMPLEMENTATION': 'rmw_zenoh_cpp', CHOICE: NATIVE},
    'eclipse': {'RMW_IMPLEMENTATION': 'rmw_zenoh_cpp', CHOICE: ECLIPSE},
    'dds': {'RMW_IMPLEMENTATION': DDS},
}

QUIET = {'PYTHONWARNINGS': 'ignore::DeprecationWarning'}
"""Python warns of a fork beside threads from 3.12 on."""


def world_on(wire: str) -> dict[str, str]:
    """Return an environment of its own for programs on a wire of WIRES; skip if the wire is not installed."""
    variables = WIRES[wire]
    require(variables['RMW_IMPLEMENTATION'])
    return isolated_env(variables['RMW_IMPLEMENTATION']) | variables | QUIET
