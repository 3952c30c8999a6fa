"""What crosses the wire: one message, request or reply on its way between two nodes."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple, TypeAlias

from goalwire.transport.contract import Payload

Path: TypeAlias = tuple['Kind', str, str, str]
"""Kind, name, source and target: what crosses on one path keeps its order."""


class Kind(Enum):
    """What crosses."""

    MESSAGE = 'message'
    REQUEST = 'request'
    REPLY = 'reply'


class Packet(NamedTuple):
    """One thing on its way. Nodes by their qualified names, '' where the graph does not know the source."""

    kind: Kind
    name: str
    """Of the topic or service: '/chatter', '/move/_action/feedback'."""
    source: str
    target: str
    payload: Payload
    delay_ns: int = 0
    overtakes: bool = False
    """True where it need not wait for what was sent before it on the same path."""

    @property
    def path(self) -> Path:
        """Where it travels."""
        return self.kind, self.name, self.source, self.target
