"""Nodes: a liveliness token, and the endpoints declared through it in the order that rmw_zenoh keeps.

A publisher's token comes before the publisher, every other's after; on the way out the token goes first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    GraphEntity,
    NodeName,
    Port,
    PublisherPort,
    Request,
    Sample,
)
from goalwire.transport.endpoint import EndpointState, OpenNode, OpenPort
from goalwire.transport.zenoh import publisher, subscription
from goalwire.transport.zenoh.client import ZenohClient
from goalwire.transport.zenoh.context import Declared, ZenohContext, undeclare
from goalwire.transport.zenoh.keyexpr import data_key
from goalwire.transport.zenoh.service import ZenohService
from goalwire.transport.zenoh.tokens import encode_endpoint, encode_node, gid_of, own_entity


class NewEndpoint(NamedTuple):
    """One endpoint on its way onto the wire, and its names there."""

    state: EndpointState
    key: str
    token: str
    entity: GraphEntity


class ZenohNode(OpenNode):
    """A declared node and its endpoints."""

    def __init__(self, context: ZenohContext, name: NodeName, state: EndpointState) -> None:
        self._context = context
        self._name = name
        self._id = context.next_id()
        token = encode_node(context.domain_id, context.id, self._id, name)
        super().__init__(state, gid_of(token))
        state.undo += [partial(undeclare, context.wire.declare_token(token)), self.ports.close]

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._opening(endpoint) as new:
            hide = self._show(new)
            new.state.undo.append(hide)
            declared = publisher.declare(self._context.wire, new.key, endpoint)
            port = publisher.ZenohPublisher(
                self._context,
                new.state,
                new.entity.gid,
                declared,
                self._context.turns.of(new.key),
                publisher.large(self._context.wire, new.key, endpoint),
            )
            new.state.undo[:] = [port.leave, partial(undeclare, declared), hide]
            return self.ports.keep(port)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._opening(endpoint) as new:
            for subscriber in subscription.declare(self._context, new.state, new.key, endpoint, deliver):
                new.state.undo.append(partial(undeclare, subscriber))
            new.state.undo.append(self._show(new))
            return self.ports.keep(OpenPort(new.state, new.entity.gid))

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._opening(endpoint) as new:
            port = ZenohService(self._context, new.state, new.key, new.entity.gid, deliver)
            new.state.undo += [port.cancel_all, partial(undeclare, port.declare())]
            new.state.undo.append(self._show(new))
            return self.ports.keep(port)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._opening(endpoint) as new:
            querier = self._context.wire.declare_querier(new.key)
            port = ZenohClient(new.state, self._context, new.entity.gid, querier)
            new.state.undo.append(port.leave)
            new.state.undo.append(self._show(new))
            return self.ports.keep(port)

    @contextmanager
    def _opening(self, endpoint: Endpoint) -> Iterator[NewEndpoint]:
        """Name an endpoint; what was declared of it is undone where the block fails."""
        context, node_id = self._context, self._id
        title = f"{endpoint.kind.value} '{endpoint.name}'"
        with self.ports.opening(title) as state, context.refusing(title):
            key = data_key(context.domain_id, endpoint.name, endpoint.type_name, endpoint.type_hash)
            token = encode_endpoint(
                context.domain_id, context.id, node_id, context.next_id(), self._name, endpoint
            )
            yield NewEndpoint(state, key, token, own_entity(token, context.id, node_id, self._name, endpoint))

    def _show(self, new: NewEndpoint) -> Callable[[], object]:
        """Declare the token; return what takes it back."""
        self._context.own[new.token] = new.entity
        token = self._context.wire.declare_token(new.token)
        return partial(self._hide, new.token, token)

    def _hide(self, text: str, token: Declared) -> None:
        undeclare(token)
        self._context.own.pop(text, None)
