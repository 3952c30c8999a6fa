"""The graph from liveliness tokens: what is declared anywhere in the domain, this session included."""

from __future__ import annotations

from goalwire.errors import RemoteError
from goalwire.transport.contract import GraphListener
from goalwire.transport.zenoh.core import Core, Declared
from goalwire.transport.zenoh.keyexpr import graph_key
from goalwire.transport.zenoh.tokens import parse


def watch(core: Core, listener: GraphListener) -> Declared:
    """Tell `listener` of every token; those there already come before this returns."""

    def on_token(token: str, is_there: bool) -> None:
        try:
            entity = core.own.get(token) or parse(token)
        except RemoteError as error:
            core.rejects.add('token', error)
            return
        if is_there:
            listener.appeared(entity)
        else:
            listener.vanished(entity)

    return core.wire.watch_tokens(graph_key(core.domain_id), on_token, waits=True)
