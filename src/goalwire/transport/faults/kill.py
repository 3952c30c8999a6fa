"""A server that dies at a named point: its process by SIGKILL, or its node alone, without a word."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass, field
from enum import Enum
from fnmatch import fnmatchcase

from goalwire.transport.faults.fault import qualified
from goalwire.transport.faults.packet import Kind, Packet

_ENCAPSULATION = 4


class Moment(Enum):
    """When a crossing is looked at, at its sender or its receiver."""

    SENDING = 'before it is sent'
    SENT = 'once it is sent'
    ARRIVED = 'when it arrives, before anybody gets it'


class Point(Enum):
    """Where in the life of a call or a goal: what must cross, with what end of its name, and when."""

    REQUEST_RECEIVED = Kind.REQUEST, '', Moment.ARRIVED
    HANDLER_DONE = Kind.REPLY, '', Moment.SENDING
    MESSAGE_SENT = Kind.MESSAGE, '', Moment.SENT
    GOAL_RECEIVED = Kind.REQUEST, '/_action/send_goal', Moment.ARRIVED
    GOAL_ACCEPTED = Kind.REPLY, '/_action/send_goal', Moment.SENT
    FEEDBACK_SENT = Kind.MESSAGE, '/_action/feedback', Moment.SENT
    RESULT_READY = Kind.REPLY, '/_action/get_result', Moment.SENDING
    """The goal has ended, its client does not know yet."""


@dataclass(eq=False)
class Kill:
    """Kills `node` when the `nth` crossing of its service, topic or action `name` comes to `point`, once.

    `process` ends this process by SIGKILL. Else the node alone is dead: nothing leaves or reaches it from
    that moment, and its endpoints vanish from the graph.
    """

    node: str
    point: Point
    name: str = '*'
    nth: int = field(default=1, kw_only=True)
    process: bool = field(default=False, kw_only=True)
    struck: int = field(default=0, init=False)
    struck_at: int = field(default=0, init=False)
    """When, in ns of the faults' clock."""
    _met: int = field(default=0, init=False, repr=False)

    def __post_init__(self) -> None:
        self.node = qualified(self.node)

    def strikes(self, moment: Moment, packet: Packet) -> bool:
        """Count a crossing of its server; whether this is the one."""
        kind, suffix, when = self.point.value
        server = packet.target if kind is Kind.REQUEST else packet.source
        if (
            self.struck
            or (kind, when) != (packet.kind, moment)
            or not fnmatchcase(server, self.node)
            or not fnmatchcase(packet.name, self.name + suffix)
            or (self.point is Point.GOAL_ACCEPTED and not packet.payload[_ENCAPSULATION])
        ):
            return False
        self._met += 1
        if self._met < self.nth:
            return False
        self.struck = 1
        return True

    @staticmethod
    def end_process() -> None:
        """End this process at once, as kill -9 does."""
        os.kill(os.getpid(), getattr(signal, 'SIGKILL', signal.SIGTERM))
