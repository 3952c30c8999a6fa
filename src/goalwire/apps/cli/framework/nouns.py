"""The nouns, and the module of each. Each module is imported when it is first needed."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.verbs import Noun

NOUNS = {
    'action': ('commands.action.noun', 'Various action related sub-commands'),
    'bag': ('commands.bag.noun', 'Various rosbag related commands'),
    'bridge': ('commands.bridge.noun', 'Serve topics, services and actions to web sockets'),
    'check': ('commands.check', 'Check interface files and launch files'),
    'completion': ('commands.completion', 'Print what makes a shell complete these commands'),
    'component': ('commands.component.noun', 'Various component related sub-commands'),
    'console': ('commands.console', 'Show the robot in the browser, and operate it there'),
    'course': (
        'commands.course.noun',
        'Learn services and actions: exercises, and checks of your work',
    ),
    'doctor': ('commands.doctor.noun', 'Check what works here, and say what to do next'),
    'fleet': ('commands.fleet.noun', 'See and command many robots, and connect them'),
    'interface': ('commands.interface', 'Show information about ROS interfaces'),
    'launch': ('commands.launch', 'Run a launch file'),
    'lifecycle': ('commands.lifecycle', 'Various lifecycle related sub-commands'),
    'mission': (
        'commands.mission.noun',
        'Run missions that go on after a crash, and answer their questions',
    ),
    'new': ('commands.new', 'Make a package: a Python project that colcon builds as well'),
    'node': ('commands.node', 'Various node related sub-commands'),
    'param': ('commands.param.noun', 'Various param related sub-commands'),
    'pkg': ('commands.pkg', 'Various package related sub-commands'),
    'router': ('commands.router', 'Run a Zenoh router for a site'),
    'run': ('commands.run', 'Run a package specific executable'),
    'secure': ('commands.secure.noun', 'Keep strangers out: keys, certificates, and who may do what'),
    'service': ('commands.service.noun', 'Various service related sub-commands'),
    'stubs': ('commands.stubs', 'Write type stubs of your own packages into the active environment'),
    'top': ('top.noun', 'Show nodes, topics, services, goals and log lines on one screen'),
    'topic': ('commands.topic.noun', 'Various topic related sub-commands'),
    'version': ('commands.version', 'Show which version this is'),
}
"""The module, below `goalwire.apps.cli`, and the summary of each noun, in the order of `--help`."""


def load(name: str) -> Noun:
    """Import a noun of NOUNS."""
    noun: Noun = import_module(f'goalwire.apps.cli.{NOUNS[name][0]}').NOUN
    return noun
