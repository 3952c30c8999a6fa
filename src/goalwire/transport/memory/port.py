"""What every declared endpoint of the memory transport has in common."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.errors import ClosedError
from goalwire.transport.contract import Endpoint, EndpointKind, GraphEntity, NodeName
from goalwire.transport.fork import ForkGuard


class Membership:
    """A place on the bus: whose it is, whether it is still held, and how it is given up."""

    __slots__ = ('_guard', '_leave', 'closed', 'entity')

    def __init__(self, entity: GraphEntity, guard: ForkGuard, leave: Callable[[], None]) -> None:
        self.entity = entity
        self.closed = False
        self._guard = guard
        self._leave = leave

    @property
    def title(self) -> str:
        """What messages call it."""
        name = self.entity.name or self.entity.node.qualified
        return f"{self.entity.kind.value} '{name}'"

    def check(self) -> None:
        """Raise ClosedError or ForkedError where the place is no longer held."""
        self._guard.check(self.title)
        if self.closed:
            raise ClosedError(
                f"{self.title} of node '{self.entity.node.qualified}' was used after it, its node or its "
                f'context had been closed; declare it again, or stop using it first'
            )

    def give_up(self) -> None:
        """Leave the bus, once; a forked child has nothing to leave."""
        if self._guard.is_forked or self.closed:
            return
        self.closed = True
        self._leave()


def describe(endpoint: Endpoint, node: GraphEntity, gid: bytes) -> GraphEntity:
    """Return what the graph shows of an endpoint of `node`."""
    return GraphEntity(
        kind=endpoint.kind,
        session=node.session,
        node_id=node.node_id,
        node=node.node,
        name=endpoint.name,
        type_name=endpoint.type_name,
        type_hash=endpoint.type_hash,
        qos=endpoint.qos.stated(),
        gid=gid,
    )


def describe_node(name: NodeName, session: str, node_id: int, gid: bytes) -> GraphEntity:
    """Return what the graph shows of a node."""
    return GraphEntity(kind=EndpointKind.NODE, session=session, node_id=node_id, node=name, gid=gid)
