"""Nodes: a liveliness token, and the endpoints declared through it in the order that rmw_zenoh keeps.

A publisher's token comes before the publisher, every other's after; on the way out the token goes first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from threading import Lock
from typing import TypeVar

import zenoh

from goalwire.errors import TransportError
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    NodeName,
    NodePort,
    Port,
    PublisherPort,
    Request,
    Sample,
)
from goalwire.transport.place import Place
from goalwire.transport.zenoh import client, publisher, subscription
from goalwire.transport.zenoh.config import reason
from goalwire.transport.zenoh.core import Core, undeclare
from goalwire.transport.zenoh.keyexpr import data_key
from goalwire.transport.zenoh.service import ZenohService
from goalwire.transport.zenoh.tokens import encode_endpoint, encode_node, gid_of

P = TypeVar('P', bound=Port)


class Declaration:
    """One endpoint on its way onto the wire: its names there, and `undo`, which takes it off again."""

    __slots__ = ('gid', 'key', 'place', 'token', 'undo')

    def __init__(self, key: str, token: str) -> None:
        self.key = key
        self.token = token
        self.gid = gid_of(token)
        self.undo = ExitStack()
        self.place: Place


class ZenohNode(NodePort):
    """A declared node and its endpoints."""

    def __init__(self, core: Core, name: NodeName, forget: Callable[[bytes], None]) -> None:
        self._core = core
        self._name = name
        self._id = core.next_id()
        self._forget = forget
        self._lock = Lock()
        self._ports: dict[bytes, Port] = {}
        token = encode_node(core.domain_id, core.id, self._id, name)
        self.gid = gid_of(token)
        self._place = Place(f"node '{name.qualified}'", core.guard, self._leave)
        self._token = core.zenoh.liveliness().declare_token(token)

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._declaring(endpoint) as new:
            token = self._show(new)
            declared = publisher.declare(self._core.zenoh, new.key, endpoint)
            port = publisher.port(new.place, new.gid, declared)
            new.undo.pop_all()
            new.undo.callback(port.release)
            new.undo.callback(undeclare, declared)
            new.undo.callback(undeclare, token)
            return self._keep(port)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._declaring(endpoint) as new:
            for subscriber in subscription.declare(self._core, new.key, endpoint, deliver):
                new.undo.callback(undeclare, subscriber)
            self._show(new)
            return self._keep(subscription.ZenohSubscription(new.place, new.gid))

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._declaring(endpoint) as new:
            port = ZenohService(self._core, new.place, new.key, new.gid, deliver)
            new.undo.callback(port.drop_all)
            new.undo.callback(undeclare, port.declare())
            self._show(new)
            return self._keep(port)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._declaring(endpoint) as new:
            querier = client.declare(self._core.zenoh, new.key)
            port = client.ZenohClient(new.place, self._core, new.gid, querier)
            new.undo.callback(port.release)
            new.undo.callback(undeclare, querier)
            self._show(new)
            return self._keep(port)

    @contextmanager
    def _declaring(self, endpoint: Endpoint) -> Iterator[Declaration]:
        """Name an endpoint; whatever was declared of it is undone where the block fails."""
        self._place.check()
        core = self._core
        key = data_key(core.domain_id, endpoint.name, endpoint.type_name, endpoint.type_hash)
        token = encode_endpoint(core.domain_id, core.id, self._id, core.next_id(), self._name, endpoint)
        new = Declaration(key, token)
        title = f"{endpoint.kind.value} '{endpoint.name}'"
        new.place = Place(title, core.guard, lambda: self._take_off(new))
        try:
            yield new
        except zenoh.ZError as error:
            new.place.give_up()
            self._place.check()  # closed by another thread in the meantime
            raise TransportError(f'{title}: zenoh refused the declaration: {reason(error)}') from None
        except BaseException:
            new.place.give_up()
            raise

    def _show(self, new: Declaration) -> zenoh.LivelinessToken:
        token = self._core.zenoh.liveliness().declare_token(new.token)
        new.undo.callback(undeclare, token)
        return token

    def _keep(self, port: P) -> P:
        with self._lock:
            self._place.check()  # once more: closing takes what it finds here, and finds nothing later
            self._ports[port.gid] = port
        return port

    def _take_off(self, new: Declaration) -> None:
        with self._lock:
            self._ports.pop(new.gid, None)
        new.undo.close()

    def close(self) -> None:
        """Close every endpoint, then leave the graph."""
        self._place.give_up()

    def _leave(self) -> None:
        with self._lock:
            ports = list(self._ports.values())
        for port in ports:
            port.close()
        undeclare(self._token)
        self._forget(self.gid)
