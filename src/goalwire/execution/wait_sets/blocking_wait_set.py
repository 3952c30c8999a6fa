"""A wait set on which a thread of the program waits itself, without an executor."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from goalwire.execution.future import Future, block_on
from goalwire.execution.rclpy_handle import entity_of
from goalwire.execution.wait_sets.waitable import Kind, WaitSet, unwatch, watch

if TYPE_CHECKING:
    from goalwire.execution.shutdown_signal import ContextLike
    from goalwire.execution.wait_sets.waitable import Waited

_reported: WeakKeyDictionary[Waited, int] = WeakKeyDictionary()
"""How many events of each guard condition waits have reported, in all wait sets. A trigger is for one wait,
and rclpy's executors make a wait set for each wait."""


class BlockingWaitSet(WaitSet):
    """Entities by kind and index; `wait` blocks until one of them is ready. For one thread at a time.

    The entities tell this wait set of their events only during `wait`. So a wait set that the program drops
    leaves nothing behind.
    """

    def __init__(
        self,
        num_subs: int,  # noqa: ARG002 - a wait set of rclpy has a fixed size; this one grows
        num_gcs: int,  # noqa: ARG002
        num_timers: int,  # noqa: ARG002
        num_clients: int,  # noqa: ARG002
        num_services: int,  # noqa: ARG002
        num_events: int,  # noqa: ARG002
        context: ContextLike,
    ) -> None:
        super().__init__(self._on_event)
        self._shutdown_signal = context.shutdown_signal
        self._event: Future[None] = Future()
        """Done after the first event since the last look."""
        self._pointers: dict[str, list[int]] = {}

    # -- methods of rclpy's WaitSet

    def clear_entities(self) -> None:
        """Remove all members, so that they can be added anew."""
        self.clear()
        self._pointers.clear()

    def wait(self, timeout_nsec: int = -1) -> None:
        """Wait until a member is ready, for `timeout_nsec` at most; negative: without limit.

        The end of the context ends the wait, too.
        """
        clock = self._shutdown_signal.clock
        deadline = None if timeout_nsec < 0 else clock.now() + timeout_nsec
        for entity in self._seen:
            watch(entity, self._wake)
        try:
            while not self._finds_ready() and self._shutdown_signal.alive:
                if deadline is not None and clock.now() >= deadline:
                    return
                block_on(self._event, self._next_look(deadline), self._shutdown_signal)
        finally:
            for entity, events in self._seen.items():
                unwatch(entity, self._wake)
                if entity.counts_up:
                    _reported[entity] = events

    def get_ready_entities(self, entity_type: Kind) -> list[int]:
        """Return the `pointer` of each member of this kind that was ready at the end of the wait.

        Raises RuntimeError for an unknown kind.
        """
        if entity_type not in self._ready:
            self.is_ready(entity_type, 0)
        pointers = self._pointers.get(entity_type, ())
        return [pointer for pointer, ready in zip(pointers, self._ready[entity_type], strict=True) if ready]

    # -- internals

    def _add(self, kind: Kind, handle: object) -> int:
        index = super()._add(kind, handle)
        self._pointers.setdefault(kind, []).append(id(entity_of(handle)))
        self._ready[kind].append(False)
        return index

    def clear(self) -> None:
        super().clear()
        for ready in self._ready.values():
            ready.clear()

    def _first_count(self, entity: Waited) -> int:
        return _reported.get(entity, 0) if entity.counts_up else 0

    def _on_event(self) -> None:
        self._event.set_result(None)

    def _finds_ready(self) -> bool:
        # The new future comes first: an event that comes from now on completes it, and the look sees the
        # earlier ones.
        self._event = Future()
        self.look()
        return any(any(ready) for ready in self._ready.values())

    def _next_look(self, deadline: int | None) -> int | None:
        """Return the steady time, in ns, at which the next timer is due, `deadline` at the latest.

        Timers of an overridden clock are left out: they tell the wait set when the program sets the time.
        """
        times = [
            timer.clock.steady_time_of(timer.next_call_ns)
            for timer in self.timers
            if not timer.is_canceled() and not timer.clock.overridden
        ]
        return min(times if deadline is None else [*times, deadline], default=None)
