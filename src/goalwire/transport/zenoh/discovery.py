"""The graph from liveliness tokens: what is declared anywhere in the domain, this session included.

A liveliness subscriber alone tells of the tokens already there in its own time. So they are asked for, and
the answer waited for, while changes queue up: a token that goes meanwhile is shown first, then taken off.
"""

from __future__ import annotations

from threading import Event

import zenoh

from goalwire.errors import RemoteError
from goalwire.transport.contract import GraphEntity, GraphListener
from goalwire.transport.outbox import Outbox
from goalwire.transport.zenoh.core import Core
from goalwire.transport.zenoh.keyexpr import graph_key
from goalwire.transport.zenoh.thread_state import pin
from goalwire.transport.zenoh.tokens import parse

ANSWER_S = 2.0
"""How long a peer that is there, but does not answer, can hold up the first look, and with it a program's
start. What it answers later is not lost: its tokens come by the subscription."""


class Watch:
    """One listener and the tokens on their way to it."""

    def __init__(self, core: Core, listener: GraphListener) -> None:
        self._core = core
        self._listener = listener
        self._changes: Outbox[tuple[bool, GraphEntity]] = Outbox(self._tell)

    def start(self) -> zenoh.Subscriber[None]:
        """Tell of everything there is, then follow the changes."""
        liveliness = self._core.zenoh.liveliness()
        key = graph_key(self._core.domain_id)
        answered = Event()
        self._core.in_flight.enter(self)
        with self._changes.first_turn():
            follow = zenoh.handlers.Callback(self._on_change, drop=self._on_drop, indirect=False)
            subscriber = liveliness.declare_subscriber(key, follow, history=True)
            ask = zenoh.handlers.Callback(self._on_answer, drop=answered.set, indirect=False)
            liveliness.get(key, ask, timeout=ANSWER_S)
            answered.wait(ANSWER_S)
        return subscriber

    def _on_answer(self, reply: zenoh.Reply) -> None:
        pin()
        if reply.ok is not None and (entity := self._read(reply.ok)) is not None:
            self._listener.appeared(entity)  # ahead of the changes, which wait for their turn

    def _on_change(self, sample: zenoh.Sample) -> None:
        pin()
        if (entity := self._read(sample)) is not None:
            self._changes.post((sample.kind == zenoh.SampleKind.PUT, entity))
            self._changes.drain()

    def _on_drop(self) -> None:
        self._core.in_flight.leave(self)

    def _read(self, sample: zenoh.Sample) -> GraphEntity | None:
        token = str(sample.key_expr)
        try:
            return self._core.own.get(token) or parse(token)
        except RemoteError as error:
            self._core.rejects.add('token', error)
            return None

    def _tell(self, change: tuple[bool, GraphEntity]) -> None:
        is_there, entity = change
        if is_there:
            self._listener.appeared(entity)
        else:
            self._listener.vanished(entity)


def watch(core: Core, listener: GraphListener) -> zenoh.Subscriber[None]:
    """Tell `listener` of every token; those there already come before this returns."""
    return Watch(core, listener).start()
