"""The list of revoked names: whose certificates are refused, and up to which time of issue.

    laptop = 2026-11-26T20:15:00Z

A certificate that was issued later under the same name is valid.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from time import time

from goalwire.errors import SecurityError
from goalwire.files import read_regular
from goalwire.security.policy import Policy

LARGEST = 1 << 20
"""The largest size of the list, in bytes."""


def read_revoked(text: str) -> dict[str, datetime]:
    """Read the list. Raises SecurityError: a list that cannot be read must not count as an empty one."""
    try:
        found = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SecurityError(f'the list of revoked names cannot be read: {error}') from None
    revoked = {}
    for name, when in found.items():
        if not isinstance(when, datetime) or when.tzinfo is None:
            raise SecurityError(
                f"the list of revoked names: '{name}' needs a time like 2026-11-26T20:15:00Z, not {when!r}"
            )
        revoked[name] = when.astimezone(UTC)
    return revoked


def load_revocations(path: Path) -> dict[str, datetime]:
    """Read the list from its file. Raises SecurityError."""
    try:
        return read_revoked(read_regular(os.fspath(path), LARGEST).decode())
    except (OSError, UnicodeDecodeError) as error:
        raise SecurityError(f"'{path}' cannot be read: {error}") from None


def write_revoked(revoked: Mapping[str, datetime]) -> str:
    """Return the list as a text that `read_revoked` can read."""
    lines = ['# Certificates of these names that were issued up to these times are refused.']
    lines += [f'"{name}" = {when:%Y-%m-%dT%H:%M:%SZ}' for name, when in sorted(revoked.items())]
    return '\n'.join(lines) + '\n'


def is_revoked(revoked: Mapping[str, datetime], name: str, issued: datetime) -> bool:
    """Whether a certificate is refused, by its name and the time from which on it is valid."""
    until = revoked.get(name)
    return until is not None and issued <= until


def why_refused(
    what: str, name: str, issued: float, ends: float, policy: Policy, revoked: Mapping[str, datetime]
) -> str:
    """Return why a certificate or a token, as `what` says, does not count any more; '' if it counts.

    `issued` and `ends` are in s since the epoch.
    """
    if is_revoked(revoked, name, datetime.fromtimestamp(issued, UTC)):
        return f"the {what} of '{name}' is revoked"
    if ends < time():
        return f"the {what} of '{name}' has expired"
    if not policy.knows(name):
        return f"'{name}' is not named in {policy.title}"
    return ''
