"""A node, as both APIs share it: its names, its port on the wire, its work queue, and its entities."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Protocol, Self
from weakref import finalize

from goalwire.entities.arguments import node_arguments
from goalwire.entities.dropped_nodes import Remains
from goalwire.entities.names import (
    ResolvedAction,
    expand_name,
    node_names,
    remap_name,
    resolve_action_names,
)
from goalwire.errors import InvalidHandle
from goalwire.execution.ready_queue import NodeWorkQueue
from goalwire.execution.time.clock import ROSClock
from goalwire.places import caller_place
from goalwire.rules.arguments import Arguments
from goalwire.rules.names import RemapRules

if TYPE_CHECKING:
    from goalwire.entities.context import Context
    from goalwire.entities.standard_types import MakeService
    from goalwire.entities.unspun_nodes import UnspunNode
    from goalwire.graph.graph import Graph
    from goalwire.rules.parameters import ParameterValue
    from goalwire.rules.parameters.unused import OverrideUse
    from goalwire.rules.statistics import NodeStatistics
    from goalwire.transport.contract import NodeName, NodePort


class Owned(Protocol):
    """An entity of a node, which is destroyed with the node."""

    def destroy(self) -> None:
        """Release the node's entity. Idempotent."""


class NodeCore:
    """One node of the graph. Entities are made over it and register with `own`."""

    def __init__(
        self,
        context: Context,
        name: str,
        namespace: str | None = None,
        *,
        cli_args: Sequence[str] | None = None,
        use_global_arguments: bool = True,
    ) -> None:
        self.context = context
        own = node_arguments(cli_args)
        process = context.arguments if use_global_arguments else Arguments()
        self._arguments = (own, process)
        self.remaps = RemapRules((*own.remaps, *process.remaps))
        self.name: NodeName = node_names(name, namespace, self.remaps, own.enclave or process.enclave or '/')
        self.work_queue = NodeWorkQueue()
        self.clock = ROSClock(source=context.shutdown_signal.clock)
        """The node's clock: system time, or /clock under `use_sim_time`."""
        self.make_service: MakeService[Any]
        """Makes the services that every node has, as services of the node's API, which sets this function."""
        self.call_timeout: float | None = None
        """The time limit in s for calls of this node whose client gives none; None: the context's."""
        port = context.session.node(self.name)
        self._port: NodePort | None = port
        self.remains = Remains(port)
        """Ends the node if the program drops it and does not destroy it."""
        self._finalizer = finalize(self, self.remains.close_soon)
        self._finalizer.atexit = False
        self._owned: dict[int, Owned] = {}
        if context.session.refusals is not None:
            # imported here: most programs have no policy
            from goalwire.entities.policy_diagnostics import publish_through

            publish_through(self, context.session.refusals, context.sends, context.ok)
        self.place = caller_place()
        """The line of the program that made the node."""
        self._unspun: UnspunNode | None = None

    @property
    def port(self) -> NodePort:
        """The node on the wire, which declares endpoints. Raises as check_open does."""
        self.check_open()
        assert self._port is not None
        return self._port

    def check_open(self) -> None:
        """Raise InvalidHandle once the node is destroyed, ShutDownError once its context has ended."""
        if self._port is None:
            raise InvalidHandle
        if not self.context.ok():
            raise self.context.shutdown_signal.end_error(f"node '{self.name.qualified}'")

    @property
    def destroyed(self) -> bool:
        """True once the node is destroyed."""
        return self._port is None

    def __enter__(self) -> Self:
        """Hold the node, as programs hold rclpy's handles; raises InvalidHandle once destroyed."""
        if self.destroyed:
            raise InvalidHandle
        return self

    def __exit__(self, *_exception: object) -> None:
        """Destroy the node."""

    @property
    def graph(self) -> Graph:
        """The discovered nodes and endpoints."""
        return self.context.graph

    @property
    def logger_name(self) -> str:
        """The name of the node's logger: 'a.b.name' for the node /a/b/name."""
        return self.name.logger

    def resolve(self, name: str, *, is_service: bool = False, only_expand: bool = False) -> str:
        """Return the fully-qualified name that a topic or service of this node gets, remapped by default.

        Raises InvalidTopicNameException or InvalidServiceNameException.
        """
        full = expand_name(name, self.name, is_service=is_service)
        return full if only_expand else remap_name(full, self.name, self.remaps, is_service=is_service)

    def resolve_action(self, name: str) -> ResolvedAction:
        """Return the names of an action of this node and its parts; raises InvalidTopicNameException."""
        return resolve_action_names(name, self.name, self.remaps)

    def parameter_overrides(self) -> dict[str, ParameterValue]:
        """Return the values that arguments give to this node's parameters; the node's own win over the
        process's.
        """
        own, process = self._arguments
        qualified = self.name.qualified
        return {**process.overrides_for(qualified), **own.overrides_for(qualified)}

    @property
    def override_use(self) -> OverrideUse | None:
        """The watcher that gets the names of declared parameters; None if the process's arguments override
        none.
        """
        takes_them = self._arguments[1] is self.context.arguments
        return self.context.override_use if takes_them else None

    def note_callback(self, kind: str) -> None:
        """Note that the program gave the node a callback; `kind` is 'timer', for example. Somebody must spin
        the node.
        """
        if self._unspun is None:
            self._unspun = self.context.unspun.add(self)
        self._unspun.callbacks[kind] += 1

    @property
    def has_callbacks(self) -> bool:
        """Whether the program gave the node any callback, apart from the services that every node has."""
        return self._unspun is not None

    def own(self, entity: Owned) -> None:
        """Register `entity`, which is then destroyed together with the node."""
        self._owned[id(entity)] = entity

    def disown(self, entity: Owned) -> None:
        """Forget an entity that destroys itself."""
        self._owned.pop(id(entity), None)

    def owned(self) -> list[Owned]:
        """Return the node's entities, oldest first."""
        return list(self._owned.values())

    def statistics(self) -> NodeStatistics:
        """Return the statistics of each of the node's entities."""
        # imported here: most programs never ask for statistics
        from goalwire.rules import statistics

        found: dict[type, list[Any]] = {}
        for entity in self.owned():
            ask = getattr(entity, 'statistics', None)
            if ask is not None:
                record = ask()
                found.setdefault(type(record), []).append(record)
        records = (tuple(found.get(kind, ())) for kind in statistics.NODE_KINDS)
        return statistics.NodeStatistics(self.name.qualified, *records)

    def destroy(self) -> None:
        """Destroy the node's entities, newest first, then the node, even if some of them raise.

        Idempotent.
        """
        self._finalizer.detach()
        with ExitStack() as ends:
            ends.callback(self._close_port)
            for entity in self.owned():
                ends.callback(entity.destroy)

    def _close_port(self) -> None:
        self._owned.clear()
        port, self._port = self._port, None
        if port is not None:
            port.close()
