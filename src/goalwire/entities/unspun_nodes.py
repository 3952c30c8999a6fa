"""Finds nodes that have callbacks and that nobody ever spun: the commonest mistake of a first program.

A warning names them when the context ends: a program that is still being set up may spin later. The warning
comes earlier if a node's callbacks have waited for seconds while `rclpy.spin`, which never returns, runs
another node.
"""

from __future__ import annotations

import sys
from collections import Counter
from typing import TYPE_CHECKING, Protocol
from weakref import ReferenceType, ref

from goalwire.errors import ExternalShutdownException
from goalwire.places import at, caller_place

if TYPE_CHECKING:
    from collections.abc import Sized

    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.transport.contract import NodeName

_MOST = 10
"""How many nodes are kept: a program that makes and drops nodes for ever keeps the first ones."""
_TEST_RUNNERS = frozenset({'pytest', 'unittest'})


class NodeOfProgram(Protocol):
    """A node, as far as it is looked at here (NodeCore)."""

    name: NodeName
    place: str
    work_queue: NodeWorkQueue

    @property
    def logger_name(self) -> str:
        """The name of the node's logger."""


class UnspunNode:
    """The facts about a node that a warning names. They do not keep the node alive."""

    def __init__(self, node: NodeOfProgram) -> None:
        self.name = node.name.qualified
        self.logger = node.logger_name
        self.place = node.place
        self.callbacks: Counter[str] = Counter()
        """How many callbacks of each kind the program made: {'timer': 2}."""
        self.is_told = False
        self._home = node.work_queue.home
        self._work_queue = ref(node.work_queue)

    @property
    def has_executor(self) -> bool:
        """Whether the node was ever added to an executor."""
        return self._home.driver is not None

    @property
    def was_spun(self) -> bool:
        """Whether the node's executor was spun; True if the executor is gone, since nobody knows then."""
        driver = None if self._home.driver is None else self._home.driver()
        return self.has_executor and getattr(driver, 'has_spun', True)

    def waits(self, now: int) -> bool:
        """Whether the node's callbacks have waited for a second at `now` (steady ns), without an executor."""
        work_queue = self._work_queue()
        return work_queue is not None and not self.has_executor and work_queue.waits(now - 10**9)

    def describe(self, *, beside_others: bool = False, beside_calls: bool = False) -> str:
        """Return what to do, in one sentence; `beside_others` if other nodes are spun without end.
        `beside_calls`: another warning advises to wait for an answer, which rclpy.spin(node) would prevent.
        """
        kinds = ', '.join(f'{n} {kind}{"s" if n > 1 else ""}' for kind, n in self.callbacks.items())
        what, call = (
            ('was added to an executor that was never spun', 'executor.spin()')
            if self.has_executor
            else ('was never spun', 'rclpy.spin(node)')
        )
        advice = f'call {call} after you have made it'
        if beside_calls:
            advice = 'add it to the executor that waits for the answer'
        if beside_others:
            advice = (
                'rclpy.spin() runs one node and does not return: write executor = SingleThreadedExecutor(), '
                'executor.add_node(…) for each node, and executor.spin()'
            )
        return f"node '{self.name}' {what}, so its callbacks never ran ({kinds}): {advice}{at(self.place)}"


class Calling(Protocol):
    """A client of a service, as far as it is looked at here."""

    full_name: str

    @property
    def node(self) -> NodeOfProgram:
        """The node that made the client."""

    @property
    def pending(self) -> Sized:
        """The calls that wait for their answers."""


class UnspunNodes:
    """The nodes of one context that have callbacks, and the clients that have called from these nodes."""

    def __init__(self) -> None:
        self._nodes: list[UnspunNode] = []
        self._calls: list[tuple[ReferenceType[Calling], str]] = []

    def add_call(self, client: Calling) -> None:
        """Note a client with the line of its first call."""
        if len(self._calls) < _MOST:
            self._calls.append((ref(client), caller_place()))

    def unanswered(self) -> list[str]:
        """Return a sentence for each client whose answers nobody waited for: its node was never spun."""
        if not tells_at_end():
            return []
        advice = 'rclpy.spin_until_future_complete(node, future) behind the call'
        if self.never_spun():
            advice = (
                'executor = SingleThreadedExecutor(), executor.add_node(…) for each node, and behind the '
                'call executor.spin_until_future_complete(future)'
            )
        return [
            f"the program ended before the answer of the service '{client.full_name}' came: write "
            f'{advice}{at(place)}'
            for client, place in ((reference(), place) for reference, place in self._calls)
            if client is not None and client.pending and client.node.work_queue.home.driver is None
        ]

    def add(self, node: NodeOfProgram) -> UnspunNode:
        """Note a node that got its first callback."""
        found = UnspunNode(node)
        if len(self._nodes) >= _MOST:
            self._nodes = [each for each in self._nodes if not each.was_spun]
        if len(self._nodes) < _MOST:
            self._nodes.append(found)
        return found

    def never_spun(self) -> list[UnspunNode]:
        """Return the nodes to warn of at the context's end: none if tests run, or after an error."""
        if not tells_at_end():
            return []
        return [node for node in self._nodes if not (node.is_told or node.was_spun)]

    def waiting(self, now: int) -> list[UnspunNode]:
        """Return the nodes whose callbacks wait while a thread spins other nodes."""
        return [node for node in self._nodes if not node.is_told and node.waits(now)]


def tells_at_end() -> bool:
    """Whether to log mistakes that only the end shows: not if tests run, nor after an error."""
    return not (_TEST_RUNNERS & sys.modules.keys() or ends_early())


def ends_early(*, has_spun: bool = False) -> bool:
    """Whether the program stops early: an error ended it, or somebody types at a prompt.

    Ctrl-C and SIGTERM are the ordinary end of a program that `has_spun` without end.
    """
    error = sys.exc_info()[1] or getattr(sys, 'last_value', None)
    if has_spun and isinstance(error, KeyboardInterrupt | ExternalShutdownException):
        error = None
    return hasattr(sys, 'ps1') or bool(sys.flags.interactive) or error is not None
