"""ros2 launch: a launch file of a package, or one by its path."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

SUMMARY = 'Run a launch file'


def _arguments(parser: ArgumentParser) -> None:
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        '-p',
        '--print',
        '--print-description',
        dest='print_description',
        action='store_true',
        help='Print the launch description without launching it',
    )
    what.add_argument(
        '-s',
        '--show-args',
        '--show-arguments',
        dest='show_args',
        action='store_true',
        help='Show the arguments that the launch file takes',
    )
    parser.add_argument(
        '-n',
        '--noninteractive',
        action='store_true',
        help='Run without a terminal; here that makes no difference',
    )
    parser.add_argument('-d', '--debug', action='store_true', help='Print more about the launch itself')
    parser.add_argument(
        '-a',
        '--show-all-subprocesses-output',
        dest='show_all',
        action='store_true',
        help='Show the output of all processes, whatever the launch file says about it',
    )
    parser.add_argument(
        '--launch-prefix', help="Put before the command of each process, as 'gdb -ex run --args'"
    )
    parser.add_argument(
        '--launch-prefix-filter', help='Regular expression of the programs that get --launch-prefix'
    )
    parser.add_argument('package_name', help='Name of the package, or the path of a launch file')
    parser.add_argument('launch_file_name', nargs='?', help='Name of the launch file')
    parser.add_argument(
        'launch_arguments',
        nargs='*',
        help="Arguments of the launch file, '<name>:=<value>' (for duplicates, the last one wins)",
    )


def _run(arguments: Namespace, output: Output) -> Outcome:
    from goalwire.errors import BadLaunchArgumentError, LaunchError, NoLaunchFileError, NoSuchPackageError
    from goalwire.launching import commands

    if output.json and not (arguments.show_args or arguments.print_description):
        raise CommandError(
            Outcome.USAGE, f'{arguments.prog}: --json goes with --show-args or --print', 'leave it out'
        )
    words = [arguments.package_name]
    if arguments.launch_file_name is not None:
        words.append(arguments.launch_file_name)
    words += arguments.launch_arguments
    try:
        path, given = commands.find_launch_file(words)
    except (NoLaunchFileError, NoSuchPackageError) as error:
        raise CommandError(Outcome.NOT_FOUND, f'{arguments.prog}: {error}') from error
    if arguments.show_all:
        os.environ['OVERRIDE_LAUNCH_PROCESS_OUTPUT'] = 'both'
    for flag, value in (
        ('launch-prefix', arguments.launch_prefix),
        ('launch-prefix-filter', arguments.launch_prefix_filter),
    ):
        if value is not None:
            given = [*given, f'{flag}:={value}']
    try:
        if arguments.print_description:
            tree = commands.show_description(path)
            output.data({'file': path, 'tree': tree.splitlines()}) if output.json else output.block(tree)
            return Outcome.OK
        if arguments.show_args:
            _show_arguments(path, output)
            return Outcome.OK
        commands.parse_arguments(given)
    except BadLaunchArgumentError as error:
        raise CommandError(Outcome.USAGE, f'{arguments.prog}: {error}') from error
    except LaunchError as error:
        raise CommandError(Outcome.FAILED, str(error)) from error
    code = commands.launch(path, given, debug=arguments.debug, noninteractive=arguments.noninteractive)
    return Outcome(code)


def _show_arguments(path: str, output: Output) -> None:
    from goalwire.launching import commands

    if not output.json:
        output.block(commands.show_arguments(path))
        return
    for argument in commands.arguments_as_data(path):
        output.data(argument)


NOUN = Noun(
    'launch',
    SUMMARY,
    (Verb('launch', SUMMARY, _run, _arguments, takes_ros_arguments=True),),
)
