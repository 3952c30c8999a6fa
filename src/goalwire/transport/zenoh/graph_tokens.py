"""Tokens become the graph: each node and each endpoint of ROS has a liveliness token.

A token that appears or vanishes is reported as the node or the endpoint of which its key tells. If a program
dies, Zenoh lets its tokens vanish when the link ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.errors import RemoteError
from goalwire.transport.zenoh.ros_keys import graph_key, own_graph_key, parse

if TYPE_CHECKING:
    from collections.abc import Iterator

    from goalwire.transport.contract import GraphListener
    from goalwire.transport.zenoh.context import ZenohContext
    from goalwire.transport.zenoh.ros_keys import RobotKeys
    from goalwire.transport.zenoh.wire import Declared


def watch_graph_tokens(
    context: ZenohContext, listener: GraphListener, scope: RobotKeys | None
) -> Iterator[Declared]:
    """Report tokens to `listener`: all, or this session's own and those in the scope.

    Those that exist now are reported before this ends.
    """

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

    if scope is None:
        yield context.wire.watch_tokens(graph_key(context.domain_id), on_token, waits=True)
        return
    own = own_graph_key(context.domain_id, context.id)
    yield context.wire.watch_tokens(own, on_token, waits=True, own_only=True)
    for key in scope.graph:
        yield context.wire.watch_tokens(key, on_token, waits=True)
