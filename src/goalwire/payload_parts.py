"""A large message in several buffers, which are joined only if the wire needs them in one piece."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from goalwire.errors import EncodeError

if TYPE_CHECKING:
    from array import array
    from collections.abc import Sequence

Part: TypeAlias = 'bytes | bytearray | memoryview | array[Any]'


class Parts:
    """An encoded message whose buffers may be arrays of the message itself.

    So its bytes go from the program's array to their place in one copy. Publishing reads the buffers before
    it returns, since the program may change the arrays then.
    """

    __slots__ = ('_joined', '_parts', '_size', '_type_name')

    def __init__(self, parts: Sequence[Part], size: int, type_name: str) -> None:
        """`size` is the number of bytes in all `parts`; `type_name` is the message's, for errors."""
        self._parts = parts
        self._size = size
        self._type_name = type_name
        self._joined: bytes | None = None

    def __len__(self) -> int:
        return self._size

    def __bytes__(self) -> bytes:
        if self._joined is None:
            joined = b''.join(self._parts)
            if len(joined) != self._size:
                raise self._changed_error()
            self._joined = joined
        return self._joined

    def write_to(self, place: memoryview) -> None:
        """Copy all bytes to `place`, which has as many. Raises EncodeError if an array has another length
        by now.
        """
        views = [memoryview(part).cast('B') for part in self._parts]
        if sum(map(len, views)) != self._size:
            raise self._changed_error()
        at = 0
        for view in views:
            end = at + len(view)
            place[at:end] = view
            at = end

    def _changed_error(self) -> EncodeError:
        return EncodeError(
            self._type_name,
            '',
            'the message changed its length while it was published: let no other thread change a message '
            'before publish() has returned',
        )
