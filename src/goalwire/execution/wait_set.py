"""The wait set that a waitable is asked with: what rclpy's programs use of rcl's, without any waiting.

An entity that is in one tells the waitable's executor of its events; see `poller`.
"""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

from goalwire.execution.handle import entity_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from goalwire.execution.timer import Timer

Kind = Literal['subscription', 'guard_condition', 'timer', 'client', 'service', 'event']
_KINDS: tuple[Kind, ...] = ('subscription', 'guard_condition', 'timer', 'client', 'service', 'event')


class Waited(Protocol):
    """What a wait set can hold. It calls all of `watchers` with each event; any thread."""

    watchers: Sequence[Callable[[], None]]

    @property
    def counts_up(self) -> bool:
        """What `events` is: how many there have been so far (True), or how many wait to be taken."""

    @property
    def events(self) -> int:
        """See `counts_up`."""


_watching = Lock()
"""Held while somebody begins or ends to watch, and nothing else."""


def watch(entity: Waited, wake: Callable[[], None]) -> None:
    """Have `wake` called with each event of `entity`, on any thread."""
    with _watching:
        entity.watchers = (*entity.watchers, wake)


def unwatch(entity: Waited, wake: Callable[[], None]) -> None:
    """Take `wake` back; nothing where it is not there."""
    with _watching:
        entity.watchers = tuple(other for other in entity.watchers if other != wake)


class WaitSet:
    """Entities by kind and index, and which of them were ready at the last `look`."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._entities: dict[str, list[Waited]] = {kind: [] for kind in _KINDS}
        self._ready: dict[str, list[bool]] = {kind: [] for kind in _KINDS}
        self._seen: dict[Waited, int] = {}
        """Everything that is watched, and how far its count was at the last look."""

    # -- what rclpy offers

    def add_subscription(self, handle: object) -> int:
        """Add a subscription; returns the index to ask `is_ready` with."""
        return self._add('subscription', handle)

    def add_guard_condition(self, handle: object) -> int:
        """Add a guard condition; it is ready in the first look after it was triggered."""
        return self._add('guard_condition', handle)

    def add_timer(self, handle: object) -> int:
        """Add a timer; it is ready from when it is due until `call_timer`."""
        return self._add('timer', handle)

    def add_client(self, handle: object) -> int:
        """Add a client; it is ready in the first look after a response has come."""
        return self._add('client', handle)

    def add_service(self, handle: object) -> int:
        """Add a service; it is ready while requests wait."""
        return self._add('service', handle)

    def add_event(self, handle: object) -> int:
        """Add an event; it is ready while there is something to take."""
        return self._add('event', handle)

    def is_ready(self, entity_type: Kind, index: int) -> bool:
        """Whether that entity was ready; raises RuntimeError for another kind, IndexError for no index."""
        ready = self._ready.get(entity_type)
        if ready is None:
            raise RuntimeError(f"'{entity_type}' is not a known entity: ask for one of {', '.join(_KINDS)}")
        if not 0 <= index < len(ready):
            raise IndexError(f'no {entity_type} was added under the index {index}: there are {len(ready)}')
        return ready[index]

    # -- what executors do with it

    def clear(self) -> None:
        """Take everything out, so that it can be added anew."""
        for entities in self._entities.values():
            entities.clear()

    def look(self) -> None:
        """Watch what is in it, and nothing else; see what is ready."""
        wanted = {entity for entities in self._entities.values() for entity in entities}
        for entity in wanted - self._seen.keys():
            self._seen[entity] = 0
            watch(entity, self._wake)  # first: what comes from now on is told, what has come is seen below
        for entity in self._seen.keys() - wanted:
            del self._seen[entity]
            unwatch(entity, self._wake)
        counts = {entity: entity.events for entity in wanted}
        for kind, entities in self._entities.items():
            self._ready[kind] = [self._is_ready(entity, counts[entity]) for entity in entities]
        self._seen = counts

    def close(self) -> None:
        """Watch nothing any more."""
        self.clear()
        self.look()

    @property
    def timers(self) -> Sequence[Timer]:
        """The timers in it."""
        return cast('list[Timer]', self._entities['timer'])

    def _is_ready(self, entity: Waited, events: int) -> bool:
        return events != self._seen[entity] if entity.counts_up else events > 0

    def _add(self, kind: Kind, handle: object) -> int:
        found: Any = entity_of(handle)
        entity: Waited = getattr(found, 'event_queue', found)
        if not hasattr(entity, 'watchers'):
            raise TypeError(
                f'add_{kind}() takes the handle of a {kind.replace("_", " ")}, got {type(handle).__name__}'
            )
        entities = self._entities[kind]
        entities.append(entity)
        return len(entities) - 1
