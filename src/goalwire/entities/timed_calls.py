"""How long calls and requests for goals may take that are given no time of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore


class TimedCalls:
    """Mixed into what calls services and actions."""

    node: NodeCore
    call_timeout: float | None = None
    """s that a call of this client may take; None: what its node says."""

    @property
    def default_timeout(self) -> float | None:
        """The nearest `call_timeout` in s: the client's, its node's, its context's. None: as in ROS 2."""
        nearest = self.call_timeout
        if nearest is None:
            node = self.node
            nearest = node.call_timeout
            if nearest is None:
                return node.context.call_timeout
        return nearest
