"""The graph from liveliness tokens: what is declared anywhere in the domain, this session included."""

from __future__ import annotations

from goalwire.errors import RemoteError
from goalwire.transport.contract import GraphListener
from goalwire.transport.zenoh.context import Declared, ZenohContext
from goalwire.transport.zenoh.keyexpr import graph_key
from goalwire.transport.zenoh.tokens import parse


def watch(context: ZenohContext, listener: GraphListener) -> Declared:
    """Tell `listener` of every token; those there already come before this returns."""

    def on_token(token: str, is_there: bool) -> None:
        try:
            entity = context.own.get(token) or parse(token)
        except RemoteError as error:
            context.rejects.add('token', error)
            return
        if is_there:
            listener.appeared(entity)
        else:
            listener.vanished(entity)

    return context.wire.watch_tokens(graph_key(context.domain_id), on_token, waits=True)
