"""One endpoint on its way onto the wire."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from goalwire.transport.dds.context import DdsContext
from goalwire.transport.dds.reader_dispatcher import ReaderDispatcher
from goalwire.transport.endpoint import EndpointState


class EndpointBuilder:
    """What is declared so far of one endpoint, and its state, which holds how that is undone."""

    __slots__ = ('_context', '_readers_to_watch', 'state', 'undo')

    def __init__(self, context: DdsContext, state: EndpointState) -> None:
        self._context = context
        self._readers_to_watch: list[tuple[str, ReaderDispatcher]] = []
        self.state = state
        self.undo = state.undo

    def take_in(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        """Let a reader's messages in once the endpoint is shown."""
        self._readers_to_watch.append((topic, dispatcher))

    def show(self, node_id: int, readers: Iterable[bytes], writers: Iterable[bytes]) -> None:
        """Tell the others whose this endpoint is, then let messages in."""
        context, gids = self._context, (*readers, *writers)
        context.announcement.add(node_id, readers, writers)
        self.undo += [context.announce, partial(context.announcement.remove, node_id, gids)]
        context.announce()
        for topic, dispatcher in self._readers_to_watch:
            context.local_readers.add(topic, dispatcher)
            self.undo.append(partial(self._shut, topic, dispatcher))
            context.wire_poller.watch(dispatcher.reader.condition, dispatcher.drain)

    def _shut(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        dispatcher.closed = True
        self._context.local_readers.remove(topic, dispatcher)
        self._context.wire_poller.unwatch(dispatcher.reader.condition)
