"""One context's session: opened as the environment says, closed once, nothing left behind."""

from __future__ import annotations

import json
from collections.abc import Callable
from threading import Lock

import zenoh

from goalwire.transport.contract import GraphListener, NodeName, NodePort, Session, SessionOptions
from goalwire.transport.endpoint import OpenSession, close_at_exit
from goalwire.transport.reports import LOGGER
from goalwire.transport.zenoh import closing, config, discovery, environment, holder, opening, settings
from goalwire.transport.zenoh.context import Declared, ZenohContext, undeclare
from goalwire.transport.zenoh.holder import Holder
from goalwire.transport.zenoh.node import ZenohNode
from goalwire.transport.zenoh.rendezvous import RENDEZVOUS
from goalwire.transport.zenoh.wire import Wire

NO_ROUTER = (Holder.MUTE, Holder.STRANGER)
"""What holds a port for nothing."""

GREETING_MS = 1000
"""How long a session waits for an answer of what held the port and was no router when it opened."""

TAKE_OVER_S = 1.0
"""How long the rendezvous may be without a holder: its port is bound, and found, again within this."""


def open_session(options: SessionOptions) -> Session:
    """Offer the rendezvous, where it is wanted, and connect. Raises TransportError or ForkedError."""
    closing.start()
    plan = config.plan()
    if plan.rendezvous is not None:
        RENDEZVOUS.offer(plan.port, plan.rendezvous)
    try:
        found = _greet_holder(plan)
        wire = opening.open_wire(plan.session)
    except BaseException:
        _stop_offering(plan)
        raise
    _look_for_router(wire, plan, found)
    context = ZenohContext(wire, options.domain_id)
    opened = ZenohSession(context, lambda: _stop_offering(plan))
    if plan.rendezvous is not None and plan.gives_way:
        opened.watchers.append(_watch_port(context, plan.port))
    return opened


def _greet_holder(plan: config.Plan) -> Holder:
    """Return what answers on the port where routers are met; what is none, but holds it, is logged.

    A session that meets such goes on trying, but never waits long for one answer, so that it can be closed at
    any time.
    """
    if plan.local is None:
        return Holder.NOBODY
    if RENDEZVOUS.holds(plan.local):
        return Holder.ZENOH
    found = holder.look(plan.local)
    if found not in NO_ROUTER:
        return found
    plan.session.insert_json5('transport/unicast/open_timeout', str(GREETING_MS))
    from goalwire.logging import get_logger  # needed only when something is broken

    get_logger(LOGGER).warning(
        f'port {plan.local} is held by {holder.name_of_holder(plan.local)}, which {found.value}: other '
        f'processes are not found; end it, or set GOALWIRE_ROUTER_PORT to a free port for all programs'
    )
    return found


def _watch_port(context: ZenohContext, port: int) -> Declared:
    """Leave the port of the rendezvous to somebody else's router from the moment the session meets it."""

    def on_router(zid: str, address: str) -> None:
        if config.local_port([address], '') == port and not settings.is_rendezvous_id(zid):
            RENDEZVOUS.leave_to_other(port)

    return context.wire.watch_routers(on_router)


def _stop_offering(plan: config.Plan) -> None:
    if plan.rendezvous is not None:
        RENDEZVOUS.stop_offering(plan.port)


def _look_for_router(wire: Wire, plan: config.Plan, found: Holder) -> None:
    """Warn where no router is met within ZENOH_ROUTER_CHECK_ATTEMPTS; sessions meet each other there.

    One that has answered, or that this process is about to offer, has a moment more to greet the session.
    """
    seconds = environment.router_check_seconds()
    if seconds is None or wire.wait_for_router(0):
        return
    offers = plan.rendezvous is not None and not RENDEZVOUS.is_left(plan.port)
    is_coming = found is Holder.ZENOH or (offers and found not in NO_ROUTER)
    patience = TAKE_OVER_S if is_coming else 0.0
    if wire.wait_for_router(max(seconds, patience)) or found in NO_ROUTER:
        return
    from goalwire.logging import get_logger  # needed only when something is broken

    if not offers:
        advice = (
            'start one (ros2 run rmw_zenoh_cpp rmw_zenohd), or set GOALWIRE_ROUTER=on to have it embedded'
        )
    else:
        advice = f'another program may hold port {plan.port}: set GOALWIRE_ROUTER_PORT to a free one'
    where = ', '.join(_endpoints(plan.session)) or 'any endpoint'
    get_logger(LOGGER).warning(
        f'no Zenoh router answers at {where}, so other processes are not found yet; {advice}'
    )


def _endpoints(session: zenoh.Config) -> list[str]:
    endpoints = json.loads(session.get_json('connect/endpoints'))
    return [str(each) for each in endpoints] if isinstance(endpoints, list) else [str(endpoints)]


class ZenohSession(OpenSession):
    """An open session and its nodes."""

    def __init__(self, context: ZenohContext, stop_offering: Callable[[], None]) -> None:
        super().__init__(context.domain_id, context.guard)
        self.id = context.id
        self.wire_poller = context.wire.wire_poller
        self._context = context
        self._lock = Lock()
        self.watchers: list[Declared] = []
        """What was declared beside the nodes."""
        self.state.undo += [stop_offering, self._disconnect, self.nodes.close, self._unwatch_all]
        close_at_exit(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        title = f"node '{name.qualified}'"
        with self.nodes.opening(title, name.logger) as state, self._context.refusing(title):
            return self.nodes.keep(ZenohNode(self._context, name, state))

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of every token of the domain."""
        self.state.check()
        watcher = discovery.watch(self._context, listener)
        with self._lock:
            self.watchers.append(watcher)

    def statistics(self) -> dict[str, int]:
        """Return how many messages, requests, replies and tokens broke the rules and were ignored."""
        return self._context.rejects.counts()

    def _unwatch_all(self) -> None:
        with self._lock:
            watchers = list(self.watchers)
        for watcher in watchers:
            undeclare(watcher)

    def _disconnect(self) -> None:
        """Send what is queued, hang up, and wait for callbacks under way."""
        try:
            self._context.wire.close()
        except self._context.errors as error:
            from goalwire.logging import get_logger  # needed only when something is broken

            reason = self._context.wire.explain(error)
            get_logger(LOGGER).warning(f'{self.state.title}: closing was cut short: {reason}')
