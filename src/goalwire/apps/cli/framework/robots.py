"""The robot of a fleet that a command looks at: `--robot NAME`, or GOALWIRE_ROBOT.

Only that robot's nodes are discovered. Names without a slash in front are names on that robot; names with a
slash are left as they are. Without a robot commands do what they do in ROS 2.
"""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome

if TYPE_CHECKING:
    from goalwire.rules.names.robots import RobotView

VARIABLE = 'GOALWIRE_ROBOT'
"""The environment variable with the name of the robot."""
SEE = 'goalwire fleet list'


def choose_robot(arguments: Namespace) -> None:
    """Choose the robot that `--robot` names for this process and its children. Raises CommandError."""
    if given := getattr(arguments, 'robot', None):
        os.environ[VARIABLE] = given
        find_robot()


def find_robot() -> str:
    """Return the name of the chosen robot; '' if there is none. Raises CommandError for a bad name."""
    given = os.environ.get(VARIABLE, '')
    if not given:
        return ''
    from goalwire.rules.names.robots import check_pattern  # imported only if a robot is chosen

    try:
        return check_pattern(given, is_name=True)
    except ValueError as error:
        raise CommandError(Outcome.BAD_VALUE, str(error), f'see: {SEE}') from None


def find_view() -> RobotView | None:
    """Return the view of the chosen robot; None if there is none."""
    robot = find_robot()
    if not robot:
        return None
    from goalwire.rules.names.robots import view_of

    return view_of(robot)


def on_robot(name: str) -> str:
    """Return a name from the command line in the namespace of the chosen robot, if there is one."""
    robot = find_robot()
    if not robot:
        return name
    from goalwire.rules.names.robots import name_below

    return name_below(robot, name)


def add_robot_argument(parser: ArgumentParser) -> None:
    """Add --robot."""
    parser.add_argument(
        '--robot',
        metavar='NAME',
        help='Look at this robot of a fleet alone; names without a slash in front are its own '
        f'(default: {VARIABLE})',
    )


_NOUNS = frozenset(
    ('action', 'component', 'console', 'lifecycle', 'node', 'param', 'service', 'top', 'topic')
)
_VERBS = frozenset((('bag', 'record'), ('bridge', 'foxglove'), ('bridge', 'rosbridge')))


def takes_robot(noun: str, verb: str) -> bool:
    """Return whether a command looks at the graph, and so takes --robot."""
    return noun in _NOUNS or (noun, verb) in _VERBS
