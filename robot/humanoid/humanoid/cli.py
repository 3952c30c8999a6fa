"""The command line: commands such as `humanoid up` and `status`, and each of the robot's programs by name."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from humanoid import lifeline
from humanoid.domain import Taken
from humanoid.fleet import BadName
from humanoid.physics.choice import NotInstalled
from humanoid.text import finite
from humanoid.view import NoView
from humanoid.world.names import SHIPPED, BadWorld

PROGRAMS = {
    'joint_state_service': 'humanoid.joints.service',
    'navigation_action_server': 'humanoid.navigation.server',
    'battery_service': 'humanoid.battery.service',
    'arm_action_server': 'humanoid.arm.server',
    'robot_state_publisher': 'humanoid.robot_state_publisher',
    'simulation': 'humanoid.physics.program',
    'world_server': 'humanoid.world.server',
    'localiser': 'humanoid.localisation.server',
    'navigator': 'humanoid.route.server',
    'motor_board': 'humanoid.driver.board',
    'mission': 'humanoid.mission.program',
}


CLOSED_PIPE = 141  # the exit code if nobody reads the output any more, as after `| head`


def main(args: Sequence[str] | None = None) -> int:
    """Run one command line and return the exit code of the process."""
    lifeline.hold(os.environ)
    try:
        try:
            return _run(list(sys.argv[1:] if args is None else args))
        finally:
            print(end='', flush=True)
    except BrokenPipeError:
        # The interpreter flushes standard output at exit; with its reader gone, that would print an error.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return CLOSED_PIPE


def _run(arguments: list[str]) -> int:
    """Run the command; arguments after a program's name, `--ros-args` included, go to that program."""
    try:
        if arguments and arguments[0] in PROGRAMS:
            program = importlib.import_module(PROGRAMS[arguments[0]])
            return int(program.main(arguments[1:]))
        options, ros_args = _options(arguments)
        if options.command == 'demo':
            from humanoid.demo import demo

            return demo(
                physics=options.physics, sim_time=options.sim_time, view=options.view, world=options.world
            )
        if options.command != 'up':
            from humanoid.operate import operate

            return operate(options, ros_args)
        from humanoid.up import up

        return up(
            physics=options.physics,
            sim_time=options.sim_time,
            names=options.name,
            view=options.view,
            world=options.world,
            params_file=options.params_file,
        )
    except KeyboardInterrupt:
        return 130
    except (Taken, NotInstalled, BadName, BadWorld, NoView) as problem:
        print(f'humanoid: {problem}', file=sys.stderr)
        return 1
    except ModuleNotFoundError as missing:
        print(_advice(missing.name or str(missing)), file=sys.stderr)
        return 1


def _advice(module: str) -> str:
    """Return the message for a module that is not installed, with advice how to get it."""
    package = module.partition('.')[0]
    if package in ('humanoid_interfaces', 'humanoid_description'):
        advice = (
            'Run `pip install ./robot/humanoid`, which brings it along, set GOALWIRE_INTERFACE_PATH '
            'to the workspace, or source it where it was built by colcon.'
        )
    else:
        advice = 'Run `pip install goalwire`, or source a ROS 2.'
    return f'humanoid: the package {package} is not found. {advice}'


def _options(arguments: list[str]) -> tuple[argparse.Namespace, list[str]]:
    """Return the parsed command with its options, and the arguments from `--ros-args` on, for ROS 2."""
    at = arguments.index('--ros-args') if '--ros-args' in arguments else len(arguments)
    parser = _parser()
    options = parser.parse_args(arguments[:at])
    if options.command in {'up', 'demo'} and options.sim_time and options.physics is False:
        parser.error('--sim-time needs the physics, which has the clock')
    if options.command == 'up' and options.sim_time and options.name:
        parser.error('--sim-time is for one robot without a name: each simulation has a time of its own')
    if options.command in {'up', 'demo'} and arguments[at:]:
        parser.error(f'{options.command} takes no --ros-args; the programs that it starts do')
    return options, arguments[at:]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='humanoid', description='A humanoid robot in services and actions.')
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')
    for name, help_text in (
        ('up', 'start every server as its own process, until Ctrl-C'),
        ('demo', 'start the servers, run the mission, sum it up'),
    ):
        command = commands.add_parser(name, help=help_text)
        command.add_argument(
            '--physics',
            action=argparse.BooleanOptionalAction,
            help='simulate the body by MuJoCo, or not; without either: where MuJoCo is installed',
        )
        command.add_argument('--sim-time', action='store_true', help="take the time from the physics' /clock")
        command.add_argument('--view', action='store_true', help='show it in the browser (goalwire[console])')
        command.add_argument('--world', help=f'walls, doors and people around it: {SHIPPED}, or a file')
        if name == 'up':
            command.add_argument(
                '--name', action='append', default=[], help='a robot of that name; may be given several times'
            )
            command.add_argument(
                '--params-file',
                type=Path,
                metavar='FILE',
                help='parameters for all programs, as ROS 2 has them',
            )
    operated = [
        commands.add_parser('status', help='the joints, the base and the battery of the robot that is up'),
        commands.add_parser('wave', help='have it wave its right hand'),
    ]
    move = commands.add_parser('move', help='send its base to X Y, in m')
    move.add_argument('x', type=finite)
    move.add_argument('y', type=finite)
    move.add_argument('--timeout', type=finite, default=60.0, help='s that the way may take (60)')
    move.add_argument('--frame', help='that X and Y are in; without: the map in a world, else odom')
    home = commands.add_parser('home', help='drive its base back to where it was brought up')
    home.add_argument('--timeout', type=finite, help='s that the way may take; without, twice what it needs')
    arm = commands.add_parser('arm', help='move JOINT to POSITION, in rad')
    arm.add_argument('joint')
    arm.add_argument('position', type=finite)
    arm.add_argument('--duration', type=finite, help='s that it takes; without, as fast as is unhurried')
    door = commands.add_parser('door', help='open or close a door of its world')
    door.add_argument('door', metavar='NAME')
    door.add_argument('wish', choices=('open', 'close'))
    push = commands.add_parser('push', help='push its pelvis with FORCE N, in the simulation')
    push.add_argument('force', type=finite)
    push.add_argument(
        '--direction', type=finite, default=0.0, help='degrees from straight ahead, left positive (0)'
    )
    push.add_argument('--duration', type=finite, default=0.2, help='s (0.2)')
    get_up = commands.add_parser('get_up', help='put it back on its feet after a fall, in the simulation')
    watch = commands.add_parser('watch', help='a line a second: where it is and what moves, until Ctrl-C')
    for command in (*operated, move, home, arm, door, push, get_up, watch):
        command.add_argument('--name', help='of the robot, where it was brought up with one')
    for name in PROGRAMS:
        commands.add_parser(name, help='one program in this process', add_help=False)
    return parser
