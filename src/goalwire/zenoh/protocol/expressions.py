"""The numbers that a session gives its keys: one number for a key on all links, as long as it is in use."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from goalwire.zenoh.protocol.declarations import Kind, declare_expression, take_back
from goalwire.zenoh.protocol.link import Link
from goalwire.zenoh.protocol.network import WireKey, wire_key

MOST = 65535
"""The highest number. If all numbers are in use, further keys travel in full."""

Namer: TypeAlias = Callable[[Link, str], WireKey]
"""Returns the name of a key on a link."""


def name_in_full(_link: Link, key: str) -> WireKey:
    """Name a key in full: for calls that interrupt their own thread in a change of the session's tables."""
    return wire_key(key)


class Expressions:
    """Keys and their numbers. Callers hold the session's lock.

    Numbers are given out in turn, so that a number which was taken back is used again as late as possible:
    messages on their way to this session may still name it.
    """

    def __init__(self) -> None:
        self.keys: dict[int, str] = {}
        self._numbers: dict[str, int] = {}
        self._uses: dict[str, int] = {}
        self._last = 0

    def use(self, key: str) -> None:
        """Give a key a number, which it keeps until `discard` was called as often as this."""
        self._uses[key] = self._uses.get(key, 0) + 1
        if key not in self._numbers and len(self.keys) < MOST:
            number = self._last
            while True:
                number = number % MOST + 1
                if number not in self.keys:
                    break
            self._last = number
            self._numbers[key] = number
            self.keys[number] = key

    def discard(self, key: str, links: tuple[Link, ...]) -> None:
        """Undo a `use`; with the last one the number is taken back on all links that know it."""
        uses = self._uses.pop(key) - 1
        if uses:
            self._uses[key] = uses
            return
        number = self._numbers.pop(key, 0)
        if number:
            del self.keys[number]
            for link in links:
                if number in link.peer.told:
                    link.peer.told.discard(number)
                    # Queued messages may still name the number, so it is undeclared after them.
                    link.outgoing.retire_expression(take_back(Kind.EXPRESSION, number))

    def declare(self, link: Link, key: str) -> WireKey:
        """Return the shortest name of a key on a link. A new number is declared to the link first."""
        out: list[bytes] = []
        name = self.name(link, key, out)
        link.outgoing.declare(*out)
        return name

    def name(self, link: Link, key: str, out: list[bytes]) -> WireKey:
        """Return the name of a key on a link; `out` gets the declarations that must be sent first."""
        number = link.peer.expression_ids.get(key)
        if number is not None:
            return wire_key(key, number)
        return self.name_own(link, key, out)

    def name_own(self, link: Link, key: str, out: list[bytes]) -> WireKey:
        """Return a name by this session's number for the key, else in full; `out` is as in `name`."""
        number = self._numbers.get(key)
        if number is None:
            return wire_key(key)
        if number not in link.peer.told:
            link.peer.told.add(number)
            out.append(declare_expression(number, key))
        return wire_key(key, number, is_senders=True)
