"""An index of values by key expression, which quickly finds all values whose expression intersects another.

Nearly all expressions of ROS 2 are plain keys, or plain keys with `/**` at the end. Both are found in dicts,
by the key and by each of its beginnings. Only the few others, the *odd* ones, are compared one by one. So a
lookup by a plain key compares it with the odd expressions only, a lookup by an expression with those that
have the same first chunks."""

from __future__ import annotations

from typing import Generic, TypeVar

from goalwire.zenoh.protocol.key_expressions import intersects, is_wild, plain_head

T = TypeVar('T')

_BELOW = '/**'


def is_odd(expression: str) -> bool:
    """Return whether an expression has wildcards in other places than a '/**' at its end."""
    return is_wild(expression) and is_wild(expression.removesuffix(_BELOW))


class KeyIndex(Generic[T]):
    """Values by their numbers, found by key expression. Code that changes the index holds a lock.

    A lookup first copies the table in one step. So a signal's handler may look up at any time.
    """

    __slots__ = ('_below', '_by_head', '_odd', '_plain', '_things')

    def __init__(self) -> None:
        self._things: dict[int, tuple[str, T]] = {}
        self._plain: dict[str, dict[int, T]] = {}
        self._below: dict[str, dict[int, T]] = {}
        """Expressions with '/**' at the end, by the text before it."""
        self._odd: dict[int, tuple[str, T]] = {}
        self._by_head: dict[str, dict[int, tuple[str, T]]] = {}
        """All expressions by their `plain_head`."""

    def __len__(self) -> int:
        return len(self._things)

    @property
    def odd(self) -> int:
        """The number of odd expressions."""
        return len(self._odd)

    def __contains__(self, number: int) -> bool:
        return number in self._things

    def add(self, number: int, key: str, thing: T) -> None:
        """Keep a value under a number that is free."""
        found = self._things[number] = key, thing
        self._by_head.setdefault(plain_head(key), {})[number] = found
        if is_odd(key):
            self._odd[number] = found
        else:
            self._same(key).setdefault(key.removesuffix(_BELOW), {})[number] = thing

    def _same(self, key: str) -> dict[str, dict[int, T]]:
        return self._below if is_wild(key) else self._plain

    def pop(self, number: int) -> tuple[str, T] | None:
        """Remove a value and return its key and the value; None for an unknown number."""
        found = self._things.pop(number, None)
        if found is None:
            return None
        head = plain_head(found[0])
        alike = self._by_head.get(head, {})
        alike.pop(number, None)
        if not alike:
            self._by_head.pop(head, None)
        if self._odd.pop(number, None) is None:
            same = self._same(found[0])
            key = found[0].removesuffix(_BELOW)
            del same[key][number]
            if not same[key]:
                del same[key]
        return found

    def meeting(self, expression: str) -> list[tuple[str, T]]:
        """Return the expressions in the index that intersect this expression, with their values."""
        if is_wild(expression):
            return [found for found in self._alike(expression) if intersects(found[0], expression)]
        out = [(expression, thing) for thing in list(self._plain.get(expression, {}).values())]
        if self._below:
            out += self._above(expression)
        if self._odd:
            out += [found for found in list(self._odd.values()) if intersects(found[0], expression)]
        return out

    def _alike(self, expression: str) -> list[tuple[str, T]]:
        """Return the expressions that may intersect an expression, by their first chunks."""
        if head := plain_head(expression):
            same, wild = self._by_head.get(head, {}), self._by_head.get('', {})
            return [*list(same.values()), *list(wild.values())]
        return list(self._things.values())

    def _above(self, key: str) -> list[tuple[str, T]]:
        """Return the expressions that end with '/**' and match a plain key."""
        out: list[tuple[str, T]] = []
        end = len(key)
        while end > 0:
            head = key[:end]
            out += [(head + _BELOW, thing) for thing in list(self._below.get(head, {}).values())]
            start = key.rfind('/', 0, end)
            if key.startswith('@', start + 1):  # no wildcard matches a chunk that begins with @
                break
            end = start
        return out

    def has_meeting(self, expression: str) -> bool:
        """Return whether an expression in the index intersects this expression."""
        return expression in self._plain or bool(self.meeting(expression))

    def all(self) -> list[tuple[int, str, T]]:
        """Return all values, the oldest first."""
        return [(number, key, thing) for number, (key, thing) in list(self._things.items())]
