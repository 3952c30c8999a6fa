"""Prints identities."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.security.certificates import Pair


def show_issued(name: str, made: Pair, output: Output) -> None:
    """Print that an identity has a new certificate."""
    until = made.certificate.not_valid_after_utc
    if output.json:
        output.data({'name': name, 'valid_until': until.isoformat()})
    else:
        output.line(f'{name} has a certificate that is valid until {until:%Y-%m-%d %H:%M} UTC')
