"""goalwire secure token: makes a token with which somebody signs in at a console or a bridge."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, add_life_argument, find_folder
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure token`."""
    parser.add_argument('name', metavar='NAME', help='A name of the policy: a person or a program')
    add_life_argument(parser)
    parser.add_argument('--delete', action='store_true', help='Delete all tokens of the name instead')
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Print a new token, which is shown only once. Raises SecurityError."""
    from goalwire.security.policy_file import load_policy
    from goalwire.security.tokens import delete_tokens, make_token

    folder, name = find_folder(arguments), arguments.name
    policy = load_policy(folder / 'policy.toml')
    if arguments.delete:
        count = delete_tokens(folder, name)
        output.show({'name': name, 'deleted': count}, f'{count} tokens of {name} are deleted')
        return Outcome.OK
    if not policy.knows(name):
        raise CommandError(
            Outcome.NOT_FOUND,
            f"{policy.title} does not name '{name}'",
            f'add it: goalwire secure add {name} --person, or a line below [identities]',
        )
    token = make_token(folder, name, arguments.days)
    ends = datetime.now(UTC) + arguments.days
    if output.json:
        output.data({'name': name, 'token': token, 'ends': ends.isoformat(timespec='seconds')})
    else:
        output.line(token)
        tell(f'{name} signs in with it until {ends:%Y-%m-%d %H:%M} UTC; it is not shown again')
    return Outcome.OK
