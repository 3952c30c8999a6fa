"""The graph from liveliness tokens: what is declared anywhere in the domain, this session included."""

from __future__ import annotations

import zenoh

from goalwire.errors import RemoteError
from goalwire.transport.contract import GraphListener
from goalwire.transport.zenoh.core import Core
from goalwire.transport.zenoh.keyexpr import graph_key
from goalwire.transport.zenoh.thread_state import pin
from goalwire.transport.zenoh.tokens import parse


def watch(core: Core, listener: GraphListener) -> zenoh.Subscriber[None]:
    """Tell `listener` of every token; those there already come before this returns."""

    def on_token(sample: zenoh.Sample) -> None:
        pin()
        try:
            entity = parse(str(sample.key_expr))
        except RemoteError as error:
            core.rejects.add('token', error)
            return
        if sample.kind == zenoh.SampleKind.PUT:
            listener.appeared(entity)
        else:
            listener.vanished(entity)

    def on_drop() -> None:
        core.in_flight.leave(on_token)

    core.in_flight.enter(on_token)
    handler = zenoh.handlers.Callback(on_token, drop=on_drop, indirect=False)
    return core.zenoh.liveliness().declare_subscriber(graph_key(core.domain_id), handler, history=True)
