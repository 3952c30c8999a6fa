"""goalwire secure init, add, issue, renew, revoke, list and token: a keystore and its identities."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import (
    add_keystore_argument,
    add_kind_arguments,
    add_life_argument,
    find_folder,
    open_keystore,
    require_cryptography,
)
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.certificates import Pair


def add_arguments(parser: ArgumentParser) -> None:
    """Add the argument of `secure list`."""
    add_keystore_argument(parser)


def add_make_keystore_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure init`."""
    parser.add_argument('folder', metavar='DIR', type=Path, help='A new or an empty folder')


def make_keystore(arguments: Namespace, output: Output) -> None:
    """Make the keystore."""
    require_cryptography()
    from goalwire.security.keystore import Keystore

    keystore = Keystore.create(arguments.folder)
    output.show(
        {'keystore': str(keystore.path)},
        f'keystore {keystore.path} is made; next: goalwire secure add NAME --robot -k {keystore.path}',
    )


def add_make_identity_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure add`."""
    parser.add_argument('name', metavar='NAME', help="The identity's name, as policy.toml has it")
    add_kind_arguments(parser)
    parser.add_argument(
        '--role',
        action='append',
        default=[],
        metavar='ROLE',
        help='A role of policy.toml (default: robot for a robot, viewer for a person); may be repeated',
    )
    add_life_argument(parser)
    add_keystore_argument(parser)


def make_identity(arguments: Namespace, output: Output) -> None:
    """Make the identity."""
    keystore = open_keystore(arguments)
    made = keystore.add(arguments.name, arguments.kind, tuple(arguments.role), arguments.days)
    _show_issued(arguments.name, made, output)


def add_issue_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure issue`."""
    parser.add_argument('name', metavar='NAME', help='An identity that policy.toml names')
    add_kind_arguments(parser)
    add_life_argument(parser)
    add_keystore_argument(parser)


def issue(arguments: Namespace, output: Output) -> None:
    """Issue the certificate."""
    made = open_keystore(arguments).issue(arguments.name, arguments.kind, arguments.days)
    _show_issued(arguments.name, made, output)


def add_renew_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure renew`."""
    parser.add_argument('names', metavar='NAME', nargs='*', help='Identities (default: all of the keystore)')
    add_life_argument(parser)
    add_keystore_argument(parser)


def renew(arguments: Namespace, output: Output) -> None:
    """Renew the named identities, or all of the keystore, one after the other."""
    keystore = open_keystore(arguments)
    for name in arguments.names or keystore.names():
        _show_issued(name, keystore.renew(name, arguments.days), output)


def add_revoke_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure revoke`."""
    parser.add_argument('name', metavar='NAME', help='The identity')
    add_keystore_argument(parser)


def revoke(arguments: Namespace, output: Output) -> None:
    """Revoke the certificate."""
    keystore = open_keystore(arguments)
    until = keystore.revoke(arguments.name)
    output.show(
        {'name': arguments.name, 'revoked': until.isoformat()},
        f'{arguments.name} is revoked in {keystore.revoked_path}; copy that file to the other machines',
    )


def list_identities(arguments: Namespace, output: Output) -> None:
    """List the identities."""
    keystore = open_keystore(arguments)
    from goalwire.security.certificates import kind_of

    for name in keystore.names():
        certificate = keystore.identity(name).certificate
        kind, until = kind_of(certificate), certificate.not_valid_after_utc
        output.show(
            {'name': name, 'kind': kind, 'valid_until': until.isoformat()},
            f'{name}: {kind}, valid until {until:%Y-%m-%d %H:%M} UTC',
        )
    for name, when in keystore.list_revoked().items():
        output.show(
            {'name': name, 'revoked': when.isoformat()},
            f'{name}: revoked at {when:%Y-%m-%d %H:%M} UTC',
            style='yellow',
        )


def _show_issued(name: str, made: Pair, output: Output) -> None:
    """Print that an identity has a new certificate."""
    until = made.certificate.not_valid_after_utc
    output.show(
        {'name': name, 'valid_until': until.isoformat()},
        f'{name} has a certificate that is valid until {until:%Y-%m-%d %H:%M} UTC',
    )


def add_give_token_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure token`."""
    parser.add_argument('name', metavar='NAME', help='A name of the policy: a person or a program')
    add_life_argument(parser)
    parser.add_argument('--delete', action='store_true', help='Delete all tokens of the name instead')
    add_keystore_argument(parser)


def give_token(arguments: Namespace, output: Output) -> Outcome:
    """Print a new token, which is shown only once. Raises SecurityError."""
    from goalwire.security.policy_file import load_policy
    from goalwire.security.sign_in.tokens import delete_tokens, make_token

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
