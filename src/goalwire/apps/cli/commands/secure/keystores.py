"""Shared by the verbs of `secure`: arguments, and how the keystore is opened."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.security import KINDS
from goalwire.security.environment import keystore_folder

if TYPE_CHECKING:
    from goalwire.security.keystore import Keystore


def add_keystore_argument(parser: ArgumentParser) -> None:
    """Add --keystore."""
    parser.add_argument(
        '-k',
        '--keystore',
        metavar='DIR',
        type=Path,
        help='The keystore (default: that of GOALWIRE_SECURITY, ROS_SECURITY_KEYSTORE, or this folder)',
    )


def require_cryptography() -> None:
    """Raise CommandError if the library for certificates is not installed."""
    try:
        import cryptography  # noqa: F401
    except ImportError:
        raise CommandError(
            Outcome.UNAVAILABLE,
            'keys and certificates need the package cryptography',
            "run pip install 'goalwire[security]'",
        ) from None


def find_folder(arguments: Namespace) -> Path:
    """Return the folder of the command's keystore, which may be missing."""
    return arguments.keystore or keystore_folder() or Path()


def open_keystore(arguments: Namespace) -> Keystore:
    """Open the keystore of a command. Raises CommandError or SecurityError."""
    require_cryptography()
    from goalwire.security.keystore import Keystore

    return Keystore(find_folder(arguments))


def add_life_argument(parser: ArgumentParser) -> None:
    """Add --days."""
    parser.add_argument(
        '--days',
        metavar='N',
        type=_days,
        default=timedelta(days=30),
        help='How long it is valid (default: 30)',
    )


def _days(text: str) -> timedelta:
    try:
        days = float(text)
        if 0 < days <= 3650:
            return timedelta(days=days)
    except ValueError:
        pass
    raise ArgumentTypeError(f"'{text}' is not a number of days above 0 and up to 3650")


def add_kind_arguments(parser: ArgumentParser) -> None:
    """Add --robot, --person, --program and --router; the user must give one of them."""
    kinds = parser.add_mutually_exclusive_group(required=True)
    for kind in KINDS:
        kinds.add_argument(
            f'--{kind}', dest='kind', action='store_const', const=kind, help=f'The identity is a {kind}'
        )
