"""goalwire secure list: the identities whose keys are in a keystore, and the revoked names."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.cli.commands.secure.keystores import add_keystore_argument, open_keystore

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `secure list`."""
    add_keystore_argument(parser)


def run(arguments: Namespace, output: Output) -> None:
    """List the identities."""
    keystore = open_keystore(arguments)
    from goalwire.security.certificates import kind_of

    for name in keystore.names():
        certificate = keystore.identity(name).certificate
        kind, until = kind_of(certificate), certificate.not_valid_after_utc
        if output.json:
            output.data({'name': name, 'kind': kind, 'valid_until': until.isoformat()})
        else:
            output.line(f'{name}: {kind}, valid until {until:%Y-%m-%d %H:%M} UTC')
    for name, when in keystore.revoked().items():
        if output.json:
            output.data({'name': name, 'revoked': when.isoformat()})
        else:
            output.line(f'{name}: revoked at {when:%Y-%m-%d %H:%M} UTC', style='yellow')
