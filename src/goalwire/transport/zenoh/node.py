"""Nodes: a liveliness token, and the endpoints declared through it in the order that rmw_zenoh keeps.

A publisher's token comes before the publisher, every other's after; on the way out the token goes first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TypeVar

from goalwire.errors import TransportError
from goalwire.transport.children import Children
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    GraphEntity,
    NodeName,
    NodePort,
    Port,
    PublisherPort,
    Request,
    Sample,
)
from goalwire.transport.endpoint_state import EndpointState
from goalwire.transport.zenoh import publisher, subscription
from goalwire.transport.zenoh.client import ZenohClient
from goalwire.transport.zenoh.context import Declared, ZenohContext, undeclare
from goalwire.transport.zenoh.keyexpr import data_key
from goalwire.transport.zenoh.service import ZenohService
from goalwire.transport.zenoh.tokens import encode_endpoint, encode_node, gid_of, own_entity

P = TypeVar('P', bound=Port)


class EndpointBuilder:
    """One endpoint on its way onto the wire: its names there, and how it is taken off again."""

    __slots__ = ('_forget', 'entity', 'gid', 'key', 'state', 'token', 'undo')

    def __init__(self, key: str, token: str, entity: GraphEntity, forget: Callable[[bytes], None]) -> None:
        self.key = key
        self.token = token
        self.entity = entity
        self.gid = entity.gid
        self._forget = forget
        self.undo: list[Callable[[], object]] = []
        """What takes it off the wire, the last step first."""
        self.state: EndpointState

    def leave(self) -> None:
        """Take it off the wire."""
        self._forget(self.gid)
        self._undo_all()

    def _undo_all(self) -> None:
        if self.undo:
            step = self.undo.pop()
            try:
                step()
            finally:
                self._undo_all()


class ZenohNode(NodePort):
    """A declared node and its endpoints."""

    def __init__(self, context: ZenohContext, name: NodeName, forget: Callable[[bytes], None]) -> None:
        self._context = context
        self._name = name
        self._id = context.next_id()
        self._forget = forget
        token = encode_node(context.domain_id, context.id, self._id, name)
        self.gid = gid_of(token)
        self._state = EndpointState(f"node '{name.qualified}'", context.guard, self._leave, name.logger)
        self._ports = Children(self._state)
        self._token = context.wire.declare_token(token)

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._declaring(endpoint) as new:
            token = self._show(new)
            new.undo = [token]
            declared = publisher.declare(self._context.wire, new.key, endpoint)
            port = publisher.ZenohPublisher(
                self._context,
                new.state,
                new.gid,
                declared,
                self._context.turns.of(new.key),
                publisher.large(self._context.wire, new.key, endpoint),
            )
            new.undo = [port.release, partial(undeclare, declared), token]
            return self._ports.keep(port)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._declaring(endpoint) as new:
            for subscriber in subscription.declare(self._context, new.state, new.key, endpoint, deliver):
                new.undo.append(partial(undeclare, subscriber))
            new.undo.append(self._show(new))
            return self._ports.keep(subscription.ZenohSubscription(new.state, new.gid))

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._declaring(endpoint) as new:
            port = ZenohService(self._context, new.state, new.key, new.gid, deliver)
            new.undo += [port.cancel_all, partial(undeclare, port.declare())]
            new.undo.append(self._show(new))
            return self._ports.keep(port)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._declaring(endpoint) as new:
            port = ZenohClient(new.state, self._context, new.gid, self._context.wire.declare_querier(new.key))
            new.undo += [port.release, self._show(new)]
            return self._ports.keep(port)

    @contextmanager
    def _declaring(self, endpoint: Endpoint) -> Iterator[EndpointBuilder]:
        """Name an endpoint; whatever was declared of it is undone where the block fails."""
        self._state.check()
        context = self._context
        key = data_key(context.domain_id, endpoint.name, endpoint.type_name, endpoint.type_hash)
        token = encode_endpoint(
            context.domain_id, context.id, self._id, context.next_id(), self._name, endpoint
        )
        new = EndpointBuilder(
            key, token, own_entity(token, context.id, self._id, self._name, endpoint), self._ports.forget
        )
        title = f"{endpoint.kind.value} '{endpoint.name}'"
        new.state = EndpointState(title, context.guard, new.leave, self._name.logger)
        try:
            yield new
        except context.errors as error:
            new.state.close()
            self._state.check()  # closed by another thread in the meantime
            reason = context.wire.explain(error)
            raise TransportError(f'{title}: zenoh refused the declaration: {reason}') from None
        except BaseException:
            new.state.close()
            raise

    def _show(self, new: EndpointBuilder) -> Callable[[], object]:
        """Declare the token; return what takes it back."""
        self._context.own[new.token] = new.entity
        token = self._context.wire.declare_token(new.token)
        return partial(self._hide, new.token, token)

    def _hide(self, text: str, token: Declared) -> None:
        undeclare(token)
        self._context.own.pop(text, None)

    def close(self) -> None:
        """Close every endpoint, then leave the graph."""
        self._state.close()

    def _leave(self) -> None:
        self._ports.close()
        undeclare(self._token)
        self._forget(self.gid)
