"""The command line: `humanoid up`, `humanoid demo`, and each program by its own name."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence

from humanoid import lifeline
from humanoid.domain import Taken

PROGRAMS = {
    'joint_state_service': 'humanoid.joints.service',
    'navigation_action_server': 'humanoid.navigation.server',
    'battery_service': 'humanoid.battery.service',
    'arm_action_server': 'humanoid.arm.server',
    'mission': 'humanoid.mission.program',
}


def main(args: Sequence[str] | None = None) -> int:
    """What follows a program's name belongs to that program, `--ros-args` included."""
    arguments = list(sys.argv[1:] if args is None else args)
    lifeline.hold(os.environ)
    try:
        if arguments and arguments[0] in PROGRAMS:
            program = importlib.import_module(PROGRAMS[arguments[0]])
            return int(program.main(arguments[1:]))
        command = _parser().parse_args(arguments).command
        if command == 'demo':
            from humanoid.demo import demo

            return demo()
        from humanoid.up import up

        return up()
    except KeyboardInterrupt:
        return 130
    except Taken as taken:
        print(f'humanoid: {taken}', file=sys.stderr)
        return 1
    except ModuleNotFoundError as missing:
        print(_advice(missing.name or str(missing)), file=sys.stderr)
        return 1


def _advice(module: str) -> str:
    """What to do about a module that is not there."""
    package = module.partition('.')[0]
    if package == 'humanoid_interfaces':
        advice = (
            'Run `pip install ./robot/humanoid`, which brings it along, set GOALWIRE_INTERFACE_PATH '
            'to the workspace, or source it where it was built by colcon.'
        )
    else:
        advice = 'Run `pip install goalwire`, or source a ROS 2.'
    return f'humanoid: the package {package} is not found. {advice}'


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='humanoid', description='A humanoid robot in services and actions.')
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')
    commands.add_parser('up', help='start every server as its own process, until Ctrl-C')
    commands.add_parser('demo', help='start the servers, run the mission, sum it up')
    for name in PROGRAMS:
        commands.add_parser(name, help='one program in this process', add_help=False)
    return parser
