"""The check of names that other sessions announce."""

from __future__ import annotations

from goalwire.errors import RemoteError

NAME_LIMIT = 1000
"""Characters of a name or type in the graph; ROS 2 itself allows about 250."""


def check_names(what: str, *names: str) -> None:
    """Raise RemoteError for a name that no log should show: it has control characters or is too long."""
    for name in names:
        if len(name) > NAME_LIMIT:
            raise RemoteError(f"{what}: {len(name)} characters, {NAME_LIMIT} are allowed: '{name}'")
        if not name.isprintable():
            raise RemoteError(f"{what}: control characters in '{name}'")
