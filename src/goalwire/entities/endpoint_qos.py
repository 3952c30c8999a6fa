"""The QoS that an endpoint is declared with: what its user left open is settled by who is there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.entities.exceptions import RCLError
from goalwire.graph.mismatch import opposite
from goalwire.protocol import qos_best_available
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.protocol.qos import QoS


def endpoint_qos(node: NodeCore, kind: EndpointKind, name: str, qos: QoS) -> QoS:
    """Return `qos` with BEST_AVAILABLE made concrete; raises RCLError for a policy that is UNKNOWN."""
    for policy in ('history', 'reliability', 'durability', 'liveliness'):
        if getattr(qos, policy).name == 'UNKNOWN':
            raise RCLError(
                f"Failed to create {kind.value}: the QoS of '{name}' has {policy} UNKNOWN, "
                f'which no endpoint can have: choose a policy'
            )
    if not qos_best_available.is_open(qos):
        return qos
    if kind in (EndpointKind.SERVICE, EndpointKind.CLIENT):
        return qos_best_available.for_service(qos)
    others = [each.qos for each in node.graph.entities(opposite(kind), name)]
    if kind is EndpointKind.PUBLISHER:
        return qos_best_available.for_publisher(qos, others)
    return qos_best_available.for_subscription(qos, others)
