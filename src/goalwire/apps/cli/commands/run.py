"""ros2 run: a program of a package."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from argparse import REMAINDER, ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.verbs import Noun, Verb

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

SUMMARY = 'Run a package specific executable'


def _arguments(parser: ArgumentParser) -> None:
    parser.add_argument('--prefix', help="Put before the program, as 'gdb -ex run --args'")
    parser.add_argument('package_name', help='Name of the package')
    parser.add_argument('executable_name', nargs='?', help='Name of the executable')
    parser.add_argument('argv', nargs=REMAINDER, help='Arguments of the program, passed on as they are')


def _run(arguments: Namespace, _output: Output) -> Outcome:
    from goalwire.errors import LaunchError
    from goalwire.launching.packages import executable

    if arguments.executable_name is None:
        raise CommandError(Outcome.USAGE, f'{arguments.prog}: {_explain_one_word(arguments.package_name)}')
    try:
        program = executable(arguments.package_name, arguments.executable_name)
    except LaunchError as error:
        raise CommandError(Outcome.NOT_FOUND, f'{arguments.prog}: {error}') from error
    try:
        prefix = shlex.split(arguments.prefix or '')
    except ValueError:
        problem = f"{arguments.prog}: --prefix '{arguments.prefix}' has a quotation mark that does not end"
        raise CommandError(Outcome.BAD_VALUE, problem) from None
    command = [*prefix, program, *arguments.argv]
    sys.stdout.flush()
    try:
        if os.name == 'posix':
            os.execvp(command[0], command)  # noqa: S606 - signals and exit code are the program's own
        return Outcome(subprocess.call(command))  # noqa: S603
    except OSError as error:
        raise CommandError(
            Outcome.UNAVAILABLE, f"{arguments.prog}: cannot start '{command[0]}': {error.strerror}"
        ) from error


def _explain_one_word(word: str) -> str:
    """Return the error for a command line with one word, without an executable."""
    if word.endswith('.py') or os.path.isfile(word):
        return (
            f"'{word}' is a file, but a package and an executable are needed; to run a file: python3 {word}"
        )
    return f'the executable is missing: write ros2 run {word} EXECUTABLE; see: ros2 pkg executables {word}'


NOUN = Noun(
    'run', SUMMARY, (Verb('run', SUMMARY, _run, _arguments, has_json=False, takes_ros_arguments=True),)
)
