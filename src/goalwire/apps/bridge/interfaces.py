"""Finds the classes of types by the names that clients use.

It requests the definitions of unknown types from nodes.
"""

from __future__ import annotations

from typing import Any

import goalwire
from goalwire.errors import UnknownInterfaceError, peer_text
from goalwire.observe.described_types import class_in_use


class Interfaces:
    """Finds classes. If no node has a type, the next `find` requests it again."""

    def __init__(self, node: goalwire.Node) -> None:
        self._node = node
        self._known: dict[str, Any] = {}

    async def find(self, name: str, kind: str) -> tuple[str, Any]:
        """Return the full name and the class of 'pkg/Name' or 'pkg/kind/Name'.

        `kind` is msg, srv or action. Raises UnknownInterfaceError.
        """
        full = full_type_name(name, kind)
        if full not in self._known:
            self._known[full] = await class_in_use(self._node, full)
        return full, self._known[full]


def full_type_name(name: str, kind: str) -> str:
    """Return 'pkg/kind/Name' for 'pkg/Name', too. Raises UnknownInterfaceError for any other text."""
    parts = name.split('/')
    if len(parts) == 2:
        parts.insert(1, kind)
    if len(parts) != 3 or parts[1] != kind or not all(part.isidentifier() for part in parts):
        raise UnknownInterfaceError(
            f"'{peer_text(name, 200)}' is not the name of a type: write package/{kind}/Name"
        )
    return '/'.join(parts)
