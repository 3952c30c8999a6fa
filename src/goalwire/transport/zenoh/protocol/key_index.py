"""An index of things by their key expression: finds quickly all whose expression intersects another one.

Nearly all expressions of ROS 2 are plain keys. Those are found by equality; only the few with wildcards are
compared one by one. So a plain key is compared with those few, an expression with all.
"""

from __future__ import annotations

from typing import Generic, TypeVar

from goalwire.transport.zenoh.protocol.key_expressions import intersects, is_wild

T = TypeVar('T')


class KeyIndex(Generic[T]):
    """Things by their ids, found by key expression. Whoever changes it holds a lock over it.

    To look something up copies at first, in one step: so a signal's handler may do it at any time.
    """

    __slots__ = ('_plain', '_things', '_wild')

    def __init__(self) -> None:
        self._things: dict[int, tuple[str, T]] = {}
        self._plain: dict[str, dict[int, T]] = {}
        self._wild: dict[int, tuple[str, T]] = {}

    def __len__(self) -> int:
        return len(self._things)

    def __contains__(self, number: int) -> bool:
        return number in self._things

    def add(self, number: int, key: str, thing: T) -> None:
        """Keep a thing under a number that is free."""
        self._things[number] = key, thing
        if is_wild(key):
            self._wild[number] = key, thing
        else:
            self._plain.setdefault(key, {})[number] = thing

    def pop(self, number: int) -> tuple[str, T] | None:
        """Take one out and return its key and itself; None where there is none."""
        found = self._things.pop(number, None)
        if found is not None and self._wild.pop(number, None) is None:
            key, _ = found
            same = self._plain[key]
            del same[number]
            if not same:
                del self._plain[key]
        return found

    def meeting(self, expression: str) -> list[tuple[str, T]]:
        """Return the keys and things whose expression intersects this one, in the order of their keys."""
        if is_wild(expression):
            return [found for found in list(self._things.values()) if intersects(found[0], expression)]
        out = [(expression, thing) for thing in list(self._plain.get(expression, {}).values())]
        if self._wild:
            out += [found for found in list(self._wild.values()) if intersects(found[0], expression)]
        return out

    def has_meeting(self, expression: str) -> bool:
        """Whether anything intersects this expression."""
        return expression in self._plain or bool(self.meeting(expression))

    def all(self) -> list[tuple[int, str, T]]:
        """Return everything, the oldest first."""
        return [(number, key, thing) for number, (key, thing) in list(self._things.items())]
