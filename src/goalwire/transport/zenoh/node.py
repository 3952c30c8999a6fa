"""Nodes: a liveliness token, and the endpoints declared through it in the order that rmw_zenoh keeps.

A publisher's token comes before the publisher, every other's after; on the way out the token goes first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TypeVar

from goalwire.errors import TransportError
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
from goalwire.transport.members import Members
from goalwire.transport.place import Place
from goalwire.transport.zenoh import publisher, subscription
from goalwire.transport.zenoh.client import ZenohClient
from goalwire.transport.zenoh.core import Core, Declared, undeclare
from goalwire.transport.zenoh.keyexpr import data_key
from goalwire.transport.zenoh.service import ZenohService
from goalwire.transport.zenoh.tokens import encode_endpoint, encode_node, gid_of, own_entity

P = TypeVar('P', bound=Port)


class Declaration:
    """One endpoint on its way onto the wire: its names there, and how it is taken off again."""

    __slots__ = ('_forget', 'entity', 'gid', 'key', 'place', 'token', 'way_out')

    def __init__(self, key: str, token: str, entity: GraphEntity, forget: Callable[[bytes], None]) -> None:
        self.key = key
        self.token = token
        self.entity = entity
        self.gid = entity.gid
        self._forget = forget
        self.way_out: list[Callable[[], object]] = []
        """What takes it off the wire, the last step first."""
        self.place: Place

    def leave(self) -> None:
        """Take it off the wire."""
        self._forget(self.gid)
        self._undo_all()

    def _undo_all(self) -> None:
        if self.way_out:
            step = self.way_out.pop()
            try:
                step()
            finally:
                self._undo_all()


class ZenohNode(NodePort):
    """A declared node and its endpoints."""

    def __init__(self, core: Core, name: NodeName, forget: Callable[[bytes], None]) -> None:
        self._core = core
        self._name = name
        self._id = core.next_id()
        self._forget = forget
        token = encode_node(core.domain_id, core.id, self._id, name)
        self.gid = gid_of(token)
        self._place = Place(f"node '{name.qualified}'", core.guard, self._leave, name.logger)
        self._ports = Members(self._place)
        self._token = core.wire.declare_token(token)

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._declaring(endpoint) as new:
            token = self._show(new)
            new.way_out = [token]
            declared = publisher.declare(self._core.wire, new.key, endpoint)
            port = publisher.ZenohPublisher(
                self._core,
                new.place,
                new.gid,
                declared,
                self._core.turns.of(new.key),
                publisher.large(self._core.wire, new.key, endpoint),
            )
            new.way_out = [port.release, partial(undeclare, declared), token]
            return self._ports.keep(port)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._declaring(endpoint) as new:
            for subscriber in subscription.declare(self._core, new.place, new.key, endpoint, deliver):
                new.way_out.append(partial(undeclare, subscriber))
            new.way_out.append(self._show(new))
            return self._ports.keep(subscription.ZenohSubscription(new.place, new.gid))

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._declaring(endpoint) as new:
            port = ZenohService(self._core, new.place, new.key, new.gid, deliver)
            new.way_out += [port.drop_all, partial(undeclare, port.declare())]
            new.way_out.append(self._show(new))
            return self._ports.keep(port)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._declaring(endpoint) as new:
            port = ZenohClient(new.place, self._core, new.gid, self._core.wire.declare_querier(new.key))
            new.way_out += [port.release, self._show(new)]
            return self._ports.keep(port)

    @contextmanager
    def _declaring(self, endpoint: Endpoint) -> Iterator[Declaration]:
        """Name an endpoint; whatever was declared of it is undone where the block fails."""
        self._place.check()
        core = self._core
        key = data_key(core.domain_id, endpoint.name, endpoint.type_name, endpoint.type_hash)
        token = encode_endpoint(core.domain_id, core.id, self._id, core.next_id(), self._name, endpoint)
        new = Declaration(
            key, token, own_entity(token, core.id, self._id, self._name, endpoint), self._ports.forget
        )
        title = f"{endpoint.kind.value} '{endpoint.name}'"
        new.place = Place(title, core.guard, new.leave, self._name.logger)
        try:
            yield new
        except core.errors as error:
            new.place.give_up()
            self._place.check()  # closed by another thread in the meantime
            reason = core.wire.explain(error)
            raise TransportError(f'{title}: zenoh refused the declaration: {reason}') from None
        except BaseException:
            new.place.give_up()
            raise

    def _show(self, new: Declaration) -> Callable[[], object]:
        """Declare the token; return what takes it back."""
        self._core.own[new.token] = new.entity
        token = self._core.wire.declare_token(new.token)
        return partial(self._hide, new.token, token)

    def _hide(self, text: str, token: Declared) -> None:
        undeclare(token)
        self._core.own.pop(text, None)

    def close(self) -> None:
        """Close every endpoint, then leave the graph."""
        self._place.give_up()

    def _leave(self) -> None:
        self._ports.close()
        undeclare(self._token)
        self._forget(self.gid)
