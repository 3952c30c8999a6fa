"""What every declared endpoint of the memory transport has in common."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.transport.contract import Endpoint, EndpointKind, GraphEntity, NodeName
from goalwire.transport.endpoint_state import EndpointState
from goalwire.transport.fork import ForkGuard


class MemoryEndpointState(EndpointState):
    """A place on the bus, and whose it is."""

    __slots__ = ('entity',)

    def __init__(self, entity: GraphEntity, guard: ForkGuard, leave: Callable[[], None]) -> None:
        super().__init__(_title(entity), guard, leave, entity.node.logger)
        self.entity = entity


def _title(entity: GraphEntity) -> str:
    """Return what messages call an endpoint or a node."""
    if entity.kind is EndpointKind.NODE:
        return f"node '{entity.node.qualified}'"
    return f"{entity.kind.value} '{entity.name}' of node '{entity.node.qualified}'"


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
