"""A record of the things that a test has seen, in order; the test can wait for more."""

from __future__ import annotations

from threading import Condition
from typing import TYPE_CHECKING, Generic, TypeVar, overload

from goalwire.execution.waiters import running_loop

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

T = TypeVar('T')

PATIENCE = 5.0
"""The time in s for which a test waits for an expected item, unless it passes another `timeout`."""

_SHOWN = 10


class Log(Generic[T]):
    """A list that any thread appends to. It reads like a list, and a test can wait for its items."""

    def __init__(self, what: str) -> None:
        """`what` names the content in error texts, such as "messages on '/chatter'"."""
        self._what = what
        self._items: list[T] = []
        self._grown = Condition()

    def append(self, item: T) -> None:
        """Add one item. Callable from any thread."""
        with self._grown:
            self._items.append(item)
            self._grown.notify_all()

    def wait_for(self, count: int = 1, *, timeout: float = PATIENCE) -> list[T]:
        """Block until there are `count` items, and return all items.

        Raises AssertionError after `timeout` s, RuntimeError inside an asyncio loop, which the call would
        block.
        """
        return self.wait_until(lambda items: len(items) >= count, f'{count}', timeout=timeout)

    def wait_until(
        self, condition: Callable[[list[T]], bool], wanted: str = 'others', *, timeout: float = PATIENCE
    ) -> list[T]:
        """Block until `condition(items)` holds; `wanted` describes the condition for the error."""
        if running_loop() is not None:
            raise RuntimeError(
                'this wait would hold up the asyncio loop that it is called in: await asyncio.to_thread(…)'
            )
        with self._grown:
            if not self._grown.wait_for(lambda: condition(self._items), timeout):
                raise AssertionError(f'wanted {wanted} {self._what} within {timeout:g} s, got {self}')
            return list(self._items)

    def clear(self) -> None:
        """Remove all items."""
        with self._grown:
            self._items.clear()

    def __len__(self) -> int:
        return len(self._items)

    def __iter__(self) -> Iterator[T]:
        return iter(tuple(self._items))

    @overload
    def __getitem__(self, index: int) -> T: ...
    @overload
    def __getitem__(self, index: slice) -> list[T]: ...
    def __getitem__(self, index: int | slice) -> T | list[T]:
        return self._items[index]

    def __eq__(self, other: object) -> bool:
        return list(self) == (list(other) if isinstance(other, Log) else other)

    __hash__ = None  # type: ignore[assignment]  # it changes, like a list

    def __str__(self) -> str:
        items = list(self)
        if not items:
            return 'none'
        more = f'\n  … and {len(items) - _SHOWN} before them' if len(items) > _SHOWN else ''
        return f'{len(items)}:' + ''.join(f'\n  {item!r}' for item in items[-_SHOWN:]) + more

    def __repr__(self) -> str:
        return f'<{self._what}: {self}>'


def describe_differences(message: object, fields: dict[str, object]) -> list[str]:
    """Describe the fields of a message that differ from the expected ones."""
    return [
        f'{name} is {getattr(message, name)!r}, not {value!r}'
        for name, value in fields.items()
        if getattr(message, name) != value
    ]
