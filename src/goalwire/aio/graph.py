"""The graph as a node sees it: nodes, endpoints, reasons why two endpoints do not match, and changes."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

from goalwire.aio.entity import Entity
from goalwire.execution.asyncio.waiting import AsyncQueue
from goalwire.graph.name_conflicts import find_mismatches, opposite
from goalwire.records import record
from goalwire.rules.qos_compatibility import QoSCompatibility, check_compatible
from goalwire.transport.contract import EndpointKind, GraphEntity

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from typing import Self

    from goalwire.entities.node import NodeCore
    from goalwire.graph.graph import Graph
    from goalwire.graph.names import NamesAndTypes

__all__ = ['EndpointKind', 'GraphChanges', 'GraphEntity', 'GraphProblem', 'GraphView', 'find_problems']


@record
class GraphProblem:
    """A conflict between endpoints that do not fit each other."""

    name: str
    """The full name of their topic or service."""
    text: str
    """The problem, and how to solve it."""
    endpoints: tuple[GraphEntity, ...]


class GraphView:
    """The discovered nodes and endpoints, this node included, at the moment of each question: Node.graph."""

    def __init__(self, node: NodeCore) -> None:
        self._node = node

    @property
    def _graph(self) -> Graph:
        self._node.check_open()
        return self._node.graph

    @property
    def version(self) -> int:
        """A number that differs after each change."""
        return self._graph.version

    def nodes(self) -> list[str]:
        """Return the full name of every node; two nodes of one name are two entries."""
        return sorted(entity.node.qualified for entity in self._graph.nodes())

    def endpoints(self) -> list[GraphEntity]:
        """Return every publisher, subscription, service and client, with node, type and QoS."""
        return self._graph.endpoints()

    def publishers(self, topic: str) -> list[GraphEntity]:
        """Return the publishers of a topic, given by its full name."""
        return self._graph.entities(EndpointKind.PUBLISHER, topic)

    def servers(self, service: str) -> list[GraphEntity]:
        """Return the servers of a service, given by its full name."""
        return self._graph.entities(EndpointKind.SERVICE, service)

    def topics(self) -> NamesAndTypes:
        """Return every topic with its types."""
        return self._graph.topic_names_and_types()

    def services(self) -> NamesAndTypes:
        """Return every service with its types, including services with clients but no server."""
        return self._graph.service_names_and_types()

    def served(self) -> NamesAndTypes:
        """Return every service that has a server, with its types."""
        return self._graph.served_names_and_types()

    def actions(self) -> NamesAndTypes:
        """Return every action with its types, including actions with clients but no server."""
        return self._graph.action_names_and_types()

    def served_actions(self) -> NamesAndTypes:
        """Return every action that has a server, with its types."""
        return self._graph.served_action_names_and_types()

    def problems(self) -> list[GraphProblem]:
        """Return the conflicts among all nodes: in types, definitions and QoS, and servers with one name."""
        return list(find_problems(self._graph.endpoints()))

    def changes(self) -> GraphChanges:
        """Return an async iterator of the graph's versions, one after each change, until it is closed."""
        return GraphChanges(self._node)


class GraphChanges(Entity):
    """An async iterator of the graph's changes. Changes between two steps of the iterator count as one, the
    latest.
    """

    def __init__(self, node: NodeCore) -> None:
        self.name = node.name.qualified
        self._node = node
        self._stream: AsyncQueue[int] = AsyncQueue(1)
        graph = node.graph
        self._watch = graph.on_change(lambda: self._stream.deliver(graph.version))
        node.own(self)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> int:
        """Wait for the next change."""
        return await anext(self._stream)

    def close(self) -> None:
        """Stop watching. Idempotent."""
        if self._stream.closed:
            return
        self._node.disown(self)
        self._watch.close()
        self._stream.close()

    destroy = close


def find_problems(endpoints: Iterable[GraphEntity]) -> Iterator[GraphProblem]:
    """Yield the conflicts among endpoints, each pair once."""
    known: dict[tuple[EndpointKind, str], list[GraphEntity]] = defaultdict(list)
    for each in endpoints:  # each endpoint is compared with the earlier ones of its name
        fellows = known[each.kind, each.name]
        counterparts = known[opposite(each.kind), each.name]
        for mismatch in find_mismatches(each, counterparts, fellows):
            yield GraphProblem(mismatch.name, str(mismatch), (mismatch.first, mismatch.second))
        if each.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}:
            for other in counterparts:
                yield from _qos_problem(each, other)
        fellows.append(each)


def _qos_problem(one: GraphEntity, other: GraphEntity) -> Iterator[GraphProblem]:
    publisher, subscription = (one, other) if one.kind is EndpointKind.PUBLISHER else (other, one)
    verdict, reasons = check_compatible(publisher.qos.stated(), subscription.qos.stated())
    if verdict is not QoSCompatibility.ERROR:
        return
    told = '; '.join(reason.removeprefix('ERROR: ') for reason in reasons.split(';') if reason)
    yield GraphProblem(
        one.name,
        f"the QoS of publisher '{publisher.node.qualified}' and subscription '{subscription.node.qualified}' "
        f"on '{one.name}' do not go together: {told}; give both the same",
        (publisher, subscription),
    )
