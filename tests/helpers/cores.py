"""Entities without a front: the least that an executor can spin."""

from __future__ import annotations

from typing import Any

from goalwire.entities.node import NodeCore


class Front:
    """The parts of a node that an executor needs."""

    def __init__(self, core: NodeCore) -> None:
        self.handle = core
        self.executor: Any = None
