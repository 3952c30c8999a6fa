"""The Zenoh session of one context, and its nodes.

GOALWIRE_ZENOH says which session is opened: `native`, the default, for goalwire's own, or `eclipse`. If the
configuration asks for something that goalwire's own does not do, eclipse-zenoh is used in its place, and
a line in the log says so.

A node is a liveliness token and the endpoints declared through it, in the order that rmw_zenoh keeps. When a
publisher is declared, its token comes first; for every other endpoint the token comes last. When an endpoint
is closed, its token goes first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from threading import RLock
from typing import TYPE_CHECKING, NamedTuple

from goalwire.concurrency.descriptors import require_free
from goalwire.errors import TransportError
from goalwire.fault_reports import LOGGER
from goalwire.security import is_asked_for
from goalwire.transport import loopback
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    GraphEntity,
    GraphListener,
    NodeName,
    NodePort,
    Port,
    PublisherPort,
    Request,
    Sample,
    Session,
    SessionOptions,
)
from goalwire.transport.endpoint import EndpointState, OpenNode, OpenPort, OpenSession, close_at_exit
from goalwire.transport.zenoh import publisher, subscription
from goalwire.transport.zenoh.context import ZenohContext
from goalwire.transport.zenoh.graph_tokens import watch_graph_tokens
from goalwire.transport.zenoh.rendezvous import RENDEZVOUS, Holder, look, name_of_holder
from goalwire.transport.zenoh.ros_keys import (
    RobotKeys,
    data_key,
    encode_endpoint,
    encode_node,
    gid_of,
    own_entity,
    robot_keys,
)
from goalwire.transport.zenoh.services import ZenohClient, ZenohService
from goalwire.transport.zenoh.settings import built_in, environment
from goalwire.transport.zenoh.settings.environment import ECLIPSE, INSTALL_ECLIPSE
from goalwire.transport.zenoh.settings.plan import Plan, local_port, make_plan
from goalwire.transport.zenoh.settings.values import Configuration
from goalwire.transport.zenoh.wire import Declared, Wire, undeclare

if TYPE_CHECKING:
    from goalwire.transport.zenoh.policy_enforcement import PolicyEnforcement


_ASKED = f'{environment.CHOICE}={ECLIPSE}'


def _open_wire(
    configuration: Configuration, security: PolicyEnforcement | None, scope: RobotKeys | None
) -> Wire:
    """Open a session. Raises TransportError or ForkedError."""
    # Only the kind of session that is opened is imported: each costs some 10 ms.
    if environment.zenoh_choice() == ECLIPSE:
        _refuse_unprotected(security, _ASKED)
        return _open_eclipse(configuration, _ASKED)
    from goalwire.transport.zenoh.settings.native import BeyondOursError, native_settings

    try:
        settings = native_settings(configuration.values, shares_with_own=environment.shares_memory())
    except BeyondOursError as error:
        _refuse_unprotected(security, f'the configuration asks for {error}, and')
        from goalwire.logging import get_logger

        get_logger(LOGGER).info(f'eclipse-zenoh is used: the configuration asks for {error}')
        return _open_eclipse(configuration, f'the configuration asks for {error}. That')
    from goalwire.transport.zenoh.native_wire import NativeWire

    return NativeWire(settings, security, scope)


def _refuse_unprotected(security: PolicyEnforcement | None, why: str) -> None:
    """Raise TransportError if the program has an identity, since eclipse-zenoh checks no policy."""
    if security is not None:
        raise TransportError(
            f"{why} opens a session of eclipse-zenoh's, which would not check the policy: leave that out, "
            f'or open it without GOALWIRE_SECURITY and ROS_SECURITY_ENABLE'
        )


def _open_eclipse(configuration: Configuration, why: str) -> Wire:
    try:
        from goalwire.transport.zenoh.eclipse_wire import EclipseWire
    except ImportError as error:
        if error.name != 'zenoh':
            raise
        raise TransportError(
            f'{why} needs eclipse-zenoh, which is not installed: run {INSTALL_ECLIPSE}'
        ) from None
    return EclipseWire(configuration)


class NewEndpoint(NamedTuple):
    """An endpoint that is being declared: its state, its key, its token and its entity."""

    state: EndpointState
    key: str
    token: str
    entity: GraphEntity


class ZenohNode(OpenNode):
    """A declared node and its endpoints."""

    def __init__(self, context: ZenohContext, name: NodeName, state: EndpointState) -> None:
        self._context = context
        self._name = name
        self._id = context.next_id()
        token = encode_node(context.domain_id, context.id, self._id, name)
        super().__init__(state, gid_of(token))
        state.undo += [partial(undeclare, context.wire.declare_token(token)), self.ports.close]

    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""
        with self._opening(endpoint) as new:
            hide = self._show(new)
            new.state.undo.append(hide)
            declared = publisher.declare(self._context.wire, new.key, endpoint)
            port = publisher.ZenohPublisher(
                self._context,
                new.state,
                new.entity.gid,
                declared,
                self._context.turns.of(new.key),
                publisher.large(endpoint),
            )
            new.state.undo[:] = [port.leave, partial(undeclare, declared), hide]
            return self.ports.keep(port)

    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription."""
        with self._opening(endpoint) as new:
            for subscriber in subscription.declare(self._context, new.state, new.key, endpoint, deliver):
                new.state.undo.append(partial(undeclare, subscriber))
            new.state.undo.append(self._show(new))
            return self.ports.keep(OpenPort(new.state, new.entity.gid))

    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        with self._opening(endpoint) as new:
            port = ZenohService(self._context, new.state, new.key, new.entity.gid, deliver)
            new.state.undo += [port.cancel_all, partial(undeclare, port.declare())]
            new.state.undo.append(self._show(new))
            return self.ports.keep(port)

    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""
        with self._opening(endpoint) as new:
            querier = self._context.wire.declare_querier(new.key)
            port = ZenohClient(new.state, self._context, new.entity.gid, querier)
            new.state.undo.append(port.leave)
            new.state.undo.append(self._show(new))
            return self.ports.keep(port)

    @contextmanager
    def _opening(self, endpoint: Endpoint) -> Iterator[NewEndpoint]:
        """Prepare an endpoint's key and token. If the block fails, its declarations are undone."""
        context, node_id = self._context, self._id
        title = f"{endpoint.kind.value} '{endpoint.name}'"
        with self.ports.opening(title) as state, context.refusing(title):
            key = data_key(context.domain_id, endpoint.name, endpoint.type_name, endpoint.type_hash)
            token = encode_endpoint(
                context.domain_id, context.id, node_id, context.next_id(), self._name, endpoint
            )
            yield NewEndpoint(state, key, token, own_entity(token, context.id, node_id, self._name, endpoint))

    def _show(self, new: NewEndpoint) -> Callable[[], object]:
        """Declare the endpoint's token; return the function that undeclares it."""
        self._context.own[new.token] = new.entity
        token = self._context.wire.declare_token(new.token)
        return partial(self._hide, new.token, token)

    def _hide(self, text: str, token: Declared) -> None:
        undeclare(token)
        self._context.own.pop(text, None)


NO_ROUTER = (Holder.MUTE, Holder.STRANGER, Holder.TLS)
"""The kinds of programs on the port that are not a router for sessions without security."""

GREETING_MS = 1000
"""How long a session waits for an answer on the port, if another program than a router held the port."""

TAKE_OVER_S = 1.0
"""The longest time after which another process has taken the rendezvous's port, and sessions have found
it."""


def open_session(options: SessionOptions) -> Session:
    """Offer the rendezvous, if it is wanted, and connect. Raises TransportError or ForkedError."""
    require_free('a Zenoh session')
    security = _secure(options.enclave) if is_asked_for() else None
    scope = None if options.view is None else robot_keys(options.domain_id, options.view)
    plan = make_plan(None if security is None else security.identity)
    if plan.rendezvous is not None:
        RENDEZVOUS.offer(plan.port, plan.rendezvous)
    try:
        # A port with TLS does not answer a greeting without TLS.
        found = Holder.NOBODY if security is not None else _greet_holder(plan)
        wire = _open_wire(plan.session, security, scope)
    except BaseException:
        _stop_offering(plan)
        raise
    _look_for_router(wire, plan, found)
    context = ZenohContext(wire, options.domain_id)
    opened = ZenohSession(context, lambda: _stop_offering(plan), scope)
    if plan.rendezvous is not None and plan.gives_way:
        opened.watchers.append(_watch_port(context, plan.port))
    return opened


def _secure(enclave: str) -> PolicyEnforcement | None:
    """Return the session's identity and policy from the keystore. Raises SecurityError."""
    # Imported here, since most programs run without security
    from goalwire.security.environment import choose_identity
    from goalwire.transport.zenoh.policy_enforcement import PolicyEnforcement

    identity = choose_identity(enclave)
    return None if identity is None else PolicyEnforcement(identity)


def _greet_holder(plan: Plan) -> Holder:
    """Return the kind of program on the rendezvous's port; warn if that is not a router.

    In that case the session goes on trying. One of eclipse-zenoh waits only shortly for each answer, so that
    it can be closed at any time, as goalwire's own can.
    """
    if plan.local is None:
        return Holder.NOBODY
    if RENDEZVOUS.holds(plan.local):
        return Holder.ZENOH
    found = look(plan.local)
    if found not in NO_ROUTER:
        return found
    if environment.zenoh_choice() == ECLIPSE:
        plan.session.set('transport/unicast/open_timeout', GREETING_MS)
    if found is Holder.TLS and plan.gives_way:
        RENDEZVOUS.hesitate(plan.local)
    from goalwire.logging import get_logger  # imported here: needed only for a warning

    advice = 'if that is a program of yours, export GOALWIRE_SECURITY=KEYSTORE:NAME for this one, too'
    get_logger(LOGGER).warning(
        f'port {plan.local} is held by {name_of_holder(plan.local)}, which {found.value}, so this program '
        f'finds no others: {advice if found is Holder.TLS else "end that program"}, or set '
        'GOALWIRE_ROUTER_PORT to a free port for all programs'
    )
    return found


def _watch_port(context: ZenohContext, port: int) -> Declared:
    """Leave the rendezvous's port to a router that is not goalwire's as soon as the session meets one."""

    def on_router(zid: str, address: str) -> None:
        protocol = address.partition('/')[0]  # tls if this program has security, else tcp
        if local_port([address], '', protocol) == port and not built_in.is_rendezvous_id(zid):
            RENDEZVOUS.leave_to_other(port)

    return context.wire.watch_routers(on_router)


def _stop_offering(plan: Plan) -> None:
    if plan.rendezvous is not None:
        RENDEZVOUS.stop_offering(plan.port)


def _look_for_router(wire: Wire, plan: Plan, found: Holder) -> None:
    """Warn if no router answers within ZENOH_ROUTER_CHECK_ATTEMPTS: only a router lets sessions meet.

    A router that has answered the greeting, or that this process is about to offer, gets TAKE_OVER_S at
    least.
    """
    seconds = environment.router_check_seconds()
    if seconds is None or wire.wait_for_router(0):
        return
    offers = plan.rendezvous is not None and not RENDEZVOUS.is_left(plan.port)
    is_coming = found is Holder.ZENOH or (offers and found not in NO_ROUTER)
    patience = TAKE_OVER_S if is_coming else 0.0
    if wire.wait_for_router(max(seconds, patience)) or found in NO_ROUTER:
        return
    from goalwire.logging import get_logger  # imported here: needed only for a warning

    if plan.local is not None and loopback.is_loopback_down():
        advice = loopback.ADVICE
    elif is_asked_for() and plan.local is not None and look(plan.local) is Holder.ZENOH:
        if plan.gives_way:
            RENDEZVOUS.hesitate(plan.local)
        advice = (
            f'port {plan.local} is held by {name_of_holder(plan.local)}, which has no security: set '
            'GOALWIRE_SECURITY for it, too, or GOALWIRE_ROUTER_PORT to a free port for those with security'
        )
    elif not offers:
        advice = f'{environment.START_ROUTER}, or set GOALWIRE_ROUTER=on to have it embedded'
    else:
        advice = f'another program may hold port {plan.port}: set GOALWIRE_ROUTER_PORT to a free one'
    where = ', '.join(_endpoints(plan.session)) or 'any endpoint'
    get_logger(LOGGER).warning(
        f'no Zenoh router answers at {where}, so other processes are not found yet; {advice}'
    )


def _endpoints(session: Configuration) -> list[str]:
    endpoints = session.at('connect/endpoints')
    return [str(each) for each in endpoints] if isinstance(endpoints, list) else [str(endpoints or '')]


class ZenohSession(OpenSession):
    """An open session and its nodes."""

    def __init__(
        self, context: ZenohContext, stop_offering: Callable[[], None], scope: RobotKeys | None = None
    ) -> None:
        super().__init__(context.domain_id, context.guard)
        self.id = context.id
        self.wire_poller = context.wire.wire_poller
        self.refusals = context.wire.refusals
        self.discovers_at_once = context.wire.discovers_at_once
        self._context = context
        self._scope = scope
        self._lock = RLock()
        self.watchers: list[Declared] = []
        """The session's own declarations; those of its nodes are kept by the nodes."""
        self.state.undo += [stop_offering, self._disconnect, self.nodes.close, self._unwatch_all]
        close_at_exit(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        title = f"node '{name.qualified}'"
        with self.nodes.opening(title, name.logger) as state, self._context.refusing(title):
            return self.nodes.keep(ZenohNode(self._context, name, state))

    def watch_graph(self, listener: GraphListener) -> None:
        """Report every node and endpoint that the session looks at to `listener`, and every change."""
        self.state.check()
        for watcher in watch_graph_tokens(self._context, listener, self._scope):
            with self._lock:
                self.watchers.append(watcher)

    def statistics(self) -> dict[str, int]:
        """Return how many messages, requests, replies and tokens broke the rules and were ignored."""
        refused = self._context.wire.refused()
        return {**refused, **self._context.rejects.counts()}

    def _unwatch_all(self) -> None:
        with self._lock:
            watchers = list(self.watchers)
        for watcher in watchers:
            undeclare(watcher)

    def _disconnect(self) -> None:
        """Send the queued messages, disconnect, and wait for callbacks under way."""
        try:
            self._context.wire.close()
        except self._context.errors as error:
            from goalwire.logging import get_logger  # imported here: needed only for a warning

            reason = self._context.wire.explain(error)
            get_logger(LOGGER).warning(f'{self.state.title}: closing was cut short: {reason}')
