"""The options of commands that serve browsers or other clients: where they listen, who may connect, TLS."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.records import record
from goalwire.security import is_asked_for
from goalwire.web_admission import is_loopback, is_usable_token, new_token

NOT_ENCRYPTED = 'it is not encrypted: give --tls-cert and --tls-key'


@record
class Access:
    """Where a command listens, and who may connect."""

    host: str
    token: str
    """'' lets everybody connect who reaches the port; allowed only on loopback."""
    tls_cert: str
    tls_key: str
    """The paths of the certificate (`tls_cert`) and its key (`tls_key`); '' without TLS."""


def add_access_options(parser: ArgumentParser, clients: str, variable: str, scheme: str) -> None:
    """Add --host, --token, --tls-cert and --tls-key.

    `clients` names those who connect, for the help text. The environment variable `variable` may hold the
    token. `scheme` is the scheme of addresses with TLS, such as 'https'.
    """
    parser.add_argument(
        '--host',
        metavar='ADDRESS',
        default='127.0.0.1',
        help=f'Where to listen (127.0.0.1: only this machine); on other addresses {clients} need a token',
    )
    parser.add_argument(
        '--token',
        metavar='TEXT',
        help=f'Token for {clients}, sent as ?token=TEXT; {variable} hides it from other users',
    )
    parser.add_argument('--tls-cert', metavar='FILE', help=f'Certificate, for {scheme}')
    parser.add_argument('--tls-key', metavar='FILE', help='Key of the certificate')


def read_access(arguments: Namespace, variable: str) -> Access:
    """Return the values of the options; a token is made if one is needed and none is given.

    With an identity there is no shared token: each client has one of its own, from the keystore.

    Raises CommandError for a certificate without its key, for a token that a URL cannot contain, and for a
    shared token beside an identity.
    """
    token = arguments.token if arguments.token is not None else os.environ.get(variable, '')
    if is_asked_for():
        if token:
            raise CommandError(
                Outcome.USAGE,
                'with an identity (GOALWIRE_SECURITY) there is no shared token',
                f'leave out --token and {variable}; make tokens by name: goalwire secure token NAME',
            )
    elif not is_loopback(arguments.host):
        token = token or new_token()
    if bool(arguments.tls_cert) != bool(arguments.tls_key):
        raise CommandError(Outcome.USAGE, 'a certificate needs its key', 'give both --tls-cert and --tls-key')
    if not is_usable_token(token):
        raise CommandError(
            Outcome.BAD_VALUE, 'a token is made of letters, digits and -_.~', 'leave it out, and one is made'
        )
    return Access(arguments.host, token, arguments.tls_cert or '', arguments.tls_key or '')
