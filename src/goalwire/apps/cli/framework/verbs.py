"""Nouns and verbs, as the modules of nouns describe them, and the parsers made of them."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple, NoReturn, TypeAlias

from goalwire import errors
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import Output
from goalwire.apps.cli.framework.robots import add_robot_argument, takes_robot

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

AddArguments: TypeAlias = Callable[[argparse.ArgumentParser], None]
Run: TypeAlias = Callable[[argparse.Namespace, Output], Outcome | None]
"""The function of a verb. Returns the outcome, None for OK. Raises CommandError or errors of goalwire."""


class Verb(NamedTuple):
    """`ros2 NOUN name …`, or the whole command of a noun without verbs."""

    name: str
    summary: str
    """One line for `--help`."""
    run: Run
    arguments: AddArguments = lambda _parser: None
    has_json: bool = True
    """True if the verb takes `--json`, as all verbs do that print data."""
    takes_ros_arguments: bool = False
    """True if the verb itself reads `--ros-args …`, as `run` and `launch` do; False if its node does."""


def lazy(module: str, function: str = 'run') -> tuple[Run, AddArguments]:
    """Return a verb's two functions, which are in a module below `commands`.

    `function` runs the verb. The other one, `add_FUNCTION_arguments`, is named `add_arguments` if several
    verbs share it or the module has one verb. The module is imported when one of them is called, because
    modules that use a node import slowly.
    """
    path = f'goalwire.apps.cli.commands.{module}'

    def run(arguments: argparse.Namespace, output: Output) -> Outcome | None:
        outcome: Outcome | None = getattr(import_module(path), function)(arguments, output)
        return outcome

    def add_arguments(parser: argparse.ArgumentParser) -> None:
        found = import_module(path)
        add = getattr(found, f'add_{function}_arguments', None) or found.add_arguments
        add(parser)

    return run, add_arguments


class Noun(NamedTuple):
    """`ros2 name VERB …`; a command without verbs has one verb that is named like itself."""

    name: str
    summary: str
    verbs: tuple[Verb, ...]
    arguments: AddArguments = lambda _parser: None
    """Adds the flags before the verb, which ROS 2 has, too; each is a `store_true`."""

    @property
    def is_command(self) -> bool:
        """True if the noun is used without a verb."""
        return len(self.verbs) == 1 and self.verbs[0].name == self.name


class Parser(argparse.ArgumentParser):
    """Ends with one line that names the help, not with pages of usage."""

    @property
    def actions(self) -> list[argparse.Action]:
        """Every argument that was added."""
        return self._actions

    def error(self, message: str) -> NoReturn:
        """Raise CommandError."""
        raise CommandError(Outcome.USAGE, f'{self.prog}: {message}', f'see: {self.prog} --help')

    def _print_message(self, message: str, file: SupportsWrite[str] | None = None) -> None:
        """Print a help text. Unlike argparse's method, this one does not ignore a closed pipe."""
        if message:
            (file or sys.stdout).write(message)


class _HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """argparse's formatter without shutil, whose import takes 5 ms; argparse makes one for every argument."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, width=_columns() - 2)


def _columns() -> int:
    """Return the terminal's width as shutil.get_terminal_size does."""
    try:
        columns = int(os.environ['COLUMNS'])
    except (KeyError, ValueError):
        columns = 0
    if columns <= 0:
        try:
            columns = os.get_terminal_size(sys.__stdout__.fileno()).columns  # type: ignore[union-attr]
        except (AttributeError, ValueError, OSError):  # standard output is missing, closed, or not a terminal
            columns = 0
    return columns or 80


def noun_parser(program: str, noun: Noun) -> Parser:
    """Return the parser of the flags between noun and verb; its help lists the verbs."""
    prog = f'{program} {noun.name}'
    width = max(len(verb.name) for verb in noun.verbs)
    verbs = '\n'.join(f'  {verb.name:{width}}  {verb.summary}' for verb in noun.verbs)
    parser = Parser(
        prog=prog,
        description=noun.summary,
        epilog=f'Commands:\n{verbs}\n\n  Call `{prog} <command> -h` for more detailed usage.',
        formatter_class=_HelpFormatter,
        usage=f'{prog} [-h] <command> ...',
        allow_abbrev=False,
    )
    noun.arguments(parser)
    return parser


def verb_parser(program: str, noun: Noun, verb: Verb) -> Parser:
    """Return the parser of a verb's arguments."""
    prog = f'{program} {noun.name}' if noun.is_command else f'{program} {noun.name} {verb.name}'
    parser = Parser(
        prog=prog,
        description=verb.summary,
        formatter_class=_HelpFormatter,
        allow_abbrev=False,
    )
    verb.arguments(parser)
    if takes_robot(noun.name, verb.name):
        add_robot_argument(parser)
    if verb.has_json:
        parser.add_argument('--json', action='store_true', help='Print JSON, one document a line')
    return parser


def did_you_mean(word: str, known: Sequence[str]) -> str:
    """Return "did you mean 'list'?", or '' if no known word is similar."""
    from difflib import get_close_matches

    return errors.did_you_mean(get_close_matches(word, known, 3, 0.6))
