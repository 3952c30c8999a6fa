"""goalwire secure audit: prints an identity's audit log, and checks that no line was changed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, find_folder
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure audit`."""
    parser.add_argument('name', metavar='NAME', help='The identity of the program that keeps the log')
    parser.add_argument('--by', metavar='WHO', default='', help='Print only what this identity did, or tried')
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """Print the entries. Raises SecurityError at the first line that does not follow the one before it."""
    from goalwire.security.audit import log_path, put_aside, read

    path = log_path(find_folder(arguments), arguments.name)
    aside = put_aside(path)
    if aside and min(aside) > 1:
        tell(f'entries before those in {next(iter(aside.values()))} were deleted with the oldest files')
    if not path.exists() and not aside:
        tell(f"{arguments.name} has nothing in its log: there is no '{path}'")
        return
    for entry in read(path):
        if arguments.by and entry.get('who') != arguments.by:
            continue
        if output.json:
            output.data(entry)
        else:
            output.line(_in_one_line(entry))


def _in_one_line(entry: Mapping[str, str]) -> str:
    """Return an entry as a line: time, outcome, name, act, values and reason."""
    parts = [f'{entry["time"]} {entry["outcome"]}: {entry["who"]}: {entry["act"]} {entry["key"]}']
    parts += [f'{name} {entry[name]}' for name in ('goal', 'what', 'messages', 'via') if entry.get(name)]
    return f'{", ".join(parts)}: {entry["reason"]}'
