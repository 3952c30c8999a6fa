"""Reports changes in the graph to callbacks, without holding a lock.

`Watchers` reports every change to all callbacks. `CounterpartWatchers` reports to an endpoint which
counterparts (endpoints on the other side of its topic or service) come and go. Changes are noted under the
graph's lock, which decides their order, and are reported after its release.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Generic, ParamSpec, TypeAlias

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.fault_reports import report_failure
from goalwire.locks import ForkableLock
from goalwire.transport.contract import EndpointKind, GraphEntity

P = ParamSpec('P')


class Watch(Generic[P]):
    """One registered callback; `close` removes it."""

    __slots__ = ('_remove', 'callback', 'closed')

    def __init__(self, remove: Callable[[Watch[P]], None], callback: Callable[P, object]) -> None:
        self._remove = remove
        self.callback = callback
        self.closed = False

    def close(self) -> None:
        """Stop calling the callback. A call that is running goes on. Idempotent."""
        self.closed = True
        self._remove(self)


class Watchers(Generic[P]):
    """The registered callbacks for one kind of event."""

    def __init__(self) -> None:
        self._lock = ForkableLock()
        self._watches: tuple[Watch[P], ...] = ()

    def add(self, callback: Callable[P, object]) -> Watch[P]:
        """Call `callback` from now on."""
        watch = Watch(self._remove, callback)
        with self._lock:
            self._watches += (watch,)
        return watch

    def _remove(self, watch: Watch[P]) -> None:
        with self._lock:
            self._watches = tuple(each for each in self._watches if each is not watch)

    def tell(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call all callbacks in the order in which they were added.

        If a callback raises, the error is logged, and the other callbacks are still called.
        """
        for watch in self._watches:
            try:
                watch.callback(*args, **kwargs)
            except Exception as error:
                report_failure('graph callback', error)


_Topic: TypeAlias = tuple[EndpointKind, str]


CounterpartWatch: TypeAlias = Watch[[GraphEntity, bool]]


class CounterpartWatchers:
    """The watches, by the kind and name of the watched endpoints, and the changes yet to be reported."""

    def __init__(self) -> None:
        self._lock = ForkableLock()
        self._by_topic: dict[_Topic, tuple[CounterpartWatch, ...]] = {}
        self._dispatcher: OrderedDispatcher[tuple[CounterpartWatch, GraphEntity, bool]] = OrderedDispatcher(
            _deliver
        )

    def add(
        self,
        kind: EndpointKind,
        name: str,
        callback: Callable[[GraphEntity, bool], object],
        there: Iterable[GraphEntity],
    ) -> CounterpartWatch:
        """Watch the endpoints of a kind and name; the existing endpoints `there` are reported first."""
        topic = kind, name
        watch = Watch(partial(self._remove, topic), callback)
        with self._lock:
            self._by_topic[topic] = (*self._by_topic.get(topic, ()), watch)
        for entity in there:
            self._dispatcher.post((watch, entity, True))
        return watch

    def _remove(self, topic: _Topic, watch: CounterpartWatch) -> None:
        with self._lock:
            others = tuple(each for each in self._by_topic.get(topic, ()) if each is not watch)
            if others:
                self._by_topic[topic] = others
            else:
                self._by_topic.pop(topic, None)

    def note(self, entity: GraphEntity, *, is_there: bool) -> None:
        """Note that an endpoint has come or gone. `tell` reports it later."""
        for watch in self._by_topic.get((entity.kind, entity.name), ()):
            self._dispatcher.post((watch, entity, is_there))

    def tell(self) -> None:
        """Call the watchers with the noted changes, unless another thread is doing that."""
        self._dispatcher.drain()


def _deliver(change: tuple[CounterpartWatch, GraphEntity, bool]) -> None:
    watch, entity, is_there = change
    if watch.closed:
        return
    try:
        watch.callback(entity, is_there)
    except Exception as error:
        report_failure('graph callback', error)
