"""Tokens with which people and programs sign in at a console or a bridge, under their names of the policy.

    [[alice]]
    sha256 = "9f86d081884c7d65…"
    issued = 2026-11-27T08:00:00Z
    ends = 2026-12-27T08:00:00Z

A keystore holds only hashes of tokens. A token is 192 random bits, so its hash needs no salt and no slow
function: nobody can try all tokens.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from pathlib import Path

from goalwire.errors import SecurityError
from goalwire.files import read_regular
from goalwire.records import record
from goalwire.security import storage
from goalwire.web_admission import new_token

LIFE = timedelta(days=30)
LARGEST = 1 << 20
"""The largest size of the file, in bytes."""

_HEAD = '# Tokens for consoles and bridges, as hashes: goalwire secure token writes this file.\n'


@record
class Token:
    """A token as a keystore knows it."""

    name: str
    sha256: str
    """The hash of the token, as hexadecimal digits."""
    issued: datetime
    ends: datetime


def tokens_path(folder: Path) -> Path:
    """Return the file of a keystore's tokens, which need not exist."""
    return folder / 'tokens.toml'


def load_tokens(folder: Path) -> tuple[Token, ...]:
    """Return the tokens of a keystore. Raises SecurityError if their file cannot be used."""
    path = tokens_path(folder)
    try:
        found = tomllib.loads(read_regular(os.fspath(path), LARGEST).decode())
        return tuple(_read(name, each) for name, having in found.items() for each in having)
    except FileNotFoundError:
        return ()
    except OSError as error:
        raise SecurityError(f"'{path}' cannot be read: {error.strerror or error}") from None
    except (ValueError, TypeError, KeyError) as error:  # the text is not TOML or UTF-8, or lacks a field
        raise SecurityError(f"'{path}' is not what goalwire secure token has written: {error}") from None


def _read(name: str, fields: dict[str, object]) -> Token:
    digest, issued, ends = fields['sha256'], fields['issued'], fields['ends']
    if not (isinstance(digest, str) and isinstance(issued, datetime) and isinstance(ends, datetime)):
        raise TypeError(f"a token of '{name}' has a wrong field")
    return Token(name, digest, issued.astimezone(UTC), ends.astimezone(UTC))


def make_token(folder: Path, name: str, life: timedelta = LIFE) -> str:
    """Add a token's hash to a keystore, for a name, and return the token, which is stored nowhere. Raises
    SecurityError.
    """
    text = new_token()
    now = datetime.now(UTC).replace(microsecond=0)
    with storage.hold_lock(folder / '.tokens.lock'):
        known = [each for each in load_tokens(folder) if each.ends > now]
        _write(folder, [*known, Token(name, _hash(text), now, now + life)])
    return text


def delete_tokens(folder: Path, name: str) -> int:
    """Delete all tokens of a name from a keystore, and return their number. Raises SecurityError."""
    with storage.hold_lock(folder / '.tokens.lock'):
        known = load_tokens(folder)
        kept = [each for each in known if each.name != name]
        if len(kept) != len(known):
            _write(folder, kept)
        return len(known) - len(kept)


def find_token(tokens: Iterable[Token], shown: str) -> Token | None:
    """Return the token that somebody shows; None if the keystore does not know it.

    Hashes are compared, so the time that this takes tells nothing about any token.
    """
    digest = _hash(shown)
    return next((each for each in tokens if each.sha256 == digest), None)


def _hash(text: str) -> str:
    return sha256(text.encode(errors='surrogatepass')).hexdigest()


def _write(folder: Path, tokens: Iterable[Token]) -> None:
    lines = [_HEAD]
    for each in sorted(tokens, key=lambda token: (token.name, token.issued)):
        lines += [
            f'[["{each.name}"]]',
            f'sha256 = "{each.sha256}"',
            f'issued = {each.issued:%Y-%m-%dT%H:%M:%SZ}',
            f'ends = {each.ends:%Y-%m-%dT%H:%M:%SZ}',
            '',
        ]
    try:
        storage.replace(tokens_path(folder), '\n'.join(lines).encode())
    except OSError as error:
        raise SecurityError(f"'{tokens_path(folder)}' cannot be written: {error.strerror or error}") from None
