"""Discovers the graph for a command: completely and quickly, without a daemon and without a node.

On goalwire's own Zenoh the graph is complete once the router has sent its declarations. On DDS, and with
eclipse-zenoh, the graph comes piece by piece. So a command waits until the searched name is there, or until
nothing has come for a while. On DDS the operating system lists the ports of all programs of this machine, so
the command waits for their answers. In the discovery range LOCALHOST no other program can answer, so the wait
ends when the last of them has answered.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from threading import Condition
from time import monotonic
from typing import TYPE_CHECKING, Self

from goalwire.apps.cli.framework.interrupts import raise_interrupts
from goalwire.apps.cli.framework.numbers import seconds
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.robots import SEE, find_robot, find_view
from goalwire.errors import NoRobotError

if TYPE_CHECKING:
    from goalwire.graph.graph import Graph
    from goalwire.rules.names.robots import RobotView
    from goalwire.transport.contract import Session

SPIN_TIME_S = 1.0
"""Seconds that discovery may take on a wire that cannot tell when it is complete; see `--spin-time`."""
FIRST_S = 0.12
"""Shortest discovery, in s, on a wire that cannot tell when it is complete.

Peers answer within some ms, or later on a busy network.
"""
NOBODY_S = 0.5
"""Seconds to wait for a first answer. An empty graph is rare, so it may be reported this late."""
MISSING_S = 1.5
"""Further seconds to wait for a given name before it is reported as missing.

They are for wires that cannot tell when discovery is complete.
"""
QUIET_S = 0.05
"""Seconds without a change, and without an outstanding answer, after which a graph counts as complete.

They are for wires that cannot tell when discovery is complete.
"""
LAST_S = 0.02
"""Replaces QUIET_S if all peers that can answer are known: one may be about to announce another context."""


def add_graph_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the flags that ROS 2's commands have if they look at the graph."""
    parser.add_argument(
        '--no-daemon', action='store_true', help='Accepted as in ROS 2: there is no daemon here'
    )
    parser.add_argument(
        '--spin-time',
        type=seconds,
        metavar='SPIN_TIME',
        help=f'Seconds for discovery on DDS (default: {SPIN_TIME_S:.0f}); on Zenoh it ends by itself',
    )
    parser.add_argument(
        '-s',
        '--use-sim-time',
        action='store_true',
        help='Accepted as in ROS 2; has no effect here',
    )


@contextmanager
def discovered(
    arguments: argparse.Namespace,
    found: Callable[[Graph], bool] | None = None,
    *,
    wait: float = 0.0,
    whole: bool = False,
    view: RobotView | None = None,
) -> Iterator[Graph]:
    """Yield the graph of the domain when it is complete, or earlier if `found(graph)` is True.

    If `found` is False on the complete graph, wait for it for another `wait` s, at least half a second. With
    `whole` the graph is complete in any case. The graph shows the robots of `view`, or the chosen robot, or
    everything. Raises TransportError, CommandError, also if the chosen robot has no node.
    """
    from goalwire.graph.graph import Graph
    from goalwire.graph.scope import within

    robot = '' if view is not None else find_robot()
    view = view or find_view()

    # `raise_interrupts` begins after `_open_session`, whose imports must not be interrupted.
    with closing(_open_session(view)) as session, raise_interrupts():
        graph = Graph(
            session.id, compares_definitions=session.compares_definitions, enforces_qos=session.enforces_qos
        )
        spin_time: float | None = getattr(arguments, 'spin_time', None)
        with _Changes(graph) as changes:
            session.watch_graph(within(view, graph, session.id))
            if not session.discovers_at_once:
                limit = SPIN_TIME_S if spin_time is None else spin_time
                changes.settle(limit, None if whole else found, session)
            elif not graph.nodes():
                changes.wait_for(lambda graph: bool(graph.nodes()), NOBODY_S)
            if found is not None:  # a busy peer may announce the name late
                changes.wait_for(found, max(wait, NOBODY_S if session.discovers_at_once else MISSING_S))
            if robot and not graph.nodes():
                changes.wait_for(lambda graph: bool(graph.nodes()), MISSING_S)
        is_missing = robot and not graph.nodes()
        if not is_missing:
            yield graph
    if is_missing:
        raise unknown_robot(robot, robots_there())


def robots_in(graph: Graph) -> list[str]:
    """Return the sorted names of the robots that have nodes in a graph."""
    from goalwire.rules.names.robots import robot_of

    return sorted({robot_of(node.node.namespace) for node in graph.nodes()} - {''})


def robots_there() -> list[str]:
    """Discover the names of all robots of the domain, without their endpoints."""
    from goalwire.rules.names.robots import view_of

    with discovered(argparse.Namespace(), view=view_of('*', nodes_only=True)) as graph:
        return robots_in(graph)


def unknown_robot(name: str, known: Iterable[str]) -> CommandError:
    """Return the error for a robot that has no nodes; it lists the robots that have."""
    return CommandError(Outcome.NOT_FOUND, str(NoRobotError(name, known)), f'see: {SEE}')


def _open_session(view: RobotView | None) -> Session:
    from goalwire.rules.domain import domain_from_environment
    from goalwire.transport import registry
    from goalwire.transport.contract import SessionOptions

    try:
        options = SessionOptions(domain_id=domain_from_environment(), view=view)
    except ValueError as error:
        raise CommandError(Outcome.USAGE, str(error)) from None
    return registry.get().open(options)


class _Changes:
    """Waits for changes of a graph."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._changed = Condition()
        self._at: float | None = None

    def _note(self) -> None:
        with self._changed:
            self._at = monotonic()
            self._changed.notify_all()

    def settle(self, limit: float, found: Callable[[Graph], bool] | None, session: Session) -> None:
        """Wait until `found` is true, or until all peers have answered and no change has come for a while.

        The wait takes `limit` s at most.
        """
        start = monotonic()
        quiet = LAST_S if session.knows_its_peers else QUIET_S
        with self._changed:
            while not (found is not None and found(self._graph)):
                if session.knows_its_peers:
                    quiet_from = (start if self._at is None else self._at) + quiet
                elif self._at is None:
                    quiet_from = start + NOBODY_S
                else:
                    quiet_from = max(self._at + quiet, start + FIRST_S)
                now, end = monotonic(), start + limit
                if now >= end or (now >= quiet_from and session.has_heard_all()):
                    return
                # An outstanding answer may come without a change of the graph, so check again in a moment.
                self._changed.wait(min(end, quiet_from if now < quiet_from else now + quiet) - now)

    def wait_for(self, found: Callable[[Graph], bool], limit: float) -> None:
        """Wait until `found` is true for the graph, `limit` s at most."""
        with self._changed:
            self._changed.wait_for(lambda: found(self._graph), limit)

    def __enter__(self) -> Self:
        self._watch = self._graph.on_change(self._note)
        return self

    def __exit__(self, *_error: object) -> None:
        self._watch.close()
