"""Which nouns there are, and which module has each. Nothing is imported before it is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.apps.cli.verbs import Noun

NOUNS = {
    'action': ('goalwire.apps.cli.action', 'Various action related sub-commands'),
    'check': ('goalwire.apps.cli.check', 'Check interface files and launch files'),
    'completion': ('goalwire.apps.cli.completion', 'Print what makes a shell complete these commands'),
    'component': ('goalwire.apps.cli.component', 'Various component related sub-commands'),
    'console': ('goalwire.apps.cli.console', 'Show the robot in the browser, and operate it there'),
    'doctor': ('goalwire.apps.cli.doctor', 'Check what works here, and say what to do next'),
    'interface': ('goalwire.apps.cli.interface', 'Show information about ROS interfaces'),
    'launch': ('goalwire.apps.cli.launch', 'Run a launch file'),
    'lifecycle': ('goalwire.apps.cli.lifecycle', 'Various lifecycle related sub-commands'),
    'new': ('goalwire.apps.cli.new', 'Make a package: a Python project that colcon builds as well'),
    'node': ('goalwire.apps.cli.node', 'Various node related sub-commands'),
    'param': ('goalwire.apps.cli.param', 'Various param related sub-commands'),
    'pkg': ('goalwire.apps.cli.pkg', 'Various package related sub-commands'),
    'router': ('goalwire.apps.cli.router', 'Run a Zenoh router for a site'),
    'run': ('goalwire.apps.cli.run', 'Run a package specific executable'),
    'service': ('goalwire.apps.cli.service', 'Various service related sub-commands'),
    'top': ('goalwire.apps.cli.top', 'Show nodes, topics, services, goals and log lines on one screen'),
    'topic': ('goalwire.apps.cli.topic', 'Various topic related sub-commands'),
    'version': ('goalwire.apps.cli.version', 'Show which version this is'),
}
"""Module and summary by name, in the order of `--help`. The module's NOUN has the same summary."""


def load(name: str) -> Noun:
    """Import a noun of NOUNS."""
    noun: Noun = import_module(NOUNS[name][0]).NOUN
    return noun
