"""A protected robot, a router that keeps the same policy, and sessions of either make that come to them.

The identity `mallory` attacks, `ann` is honest, `robby` is the robot, `site` the router. Everybody may
publish MARKER and subscribe to OPEN, so that a test knows when all that was sent before has arrived.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from datetime import timedelta
from os import urandom

import zenoh
from helpers.isolation import free_port
from helpers.patience import wait_for
from helpers.zenoh_sides import Heard, Ours, Side

from goalwire.errors import TransportError
from goalwire.records import replace
from goalwire.security.environment import Chosen
from goalwire.security.keystore import Keystore
from goalwire.security.policy import Verb
from goalwire.transport.zenoh.native_wire import NativeWire
from goalwire.transport.zenoh.policy_enforcement import PolicyEnforcement
from goalwire.transport.zenoh.router import router
from goalwire.zenoh.io.endpoints import TlsFiles
from goalwire.zenoh.io.settings import Settings

HASH = 'RIHS01_00'


def key_of(name: str, dds_type: str = 'std_msgs::msg::dds_::String_') -> str:
    """Return the key of a topic or service of domain 0, as rmw_zenoh writes it."""
    return f'0{name}/{dds_type}/{HASH}'


SERVICE_TYPE = 'std_srvs::srv::dds_::Empty_'
MARKER, OPEN, TOPIC = key_of('/marker'), key_of('/open'), key_of('/secret')
FEEDBACK = key_of('/secret/_action/feedback', 'a::action::dds_::Walk_FeedbackMessage_')
SERVICES = {
    Verb.CALL: key_of('/secret', SERVICE_TYPE),
    Verb.SEND: key_of('/secret/_action/send_goal', 'a::action::dds_::Walk_SendGoal_'),
    Verb.CANCEL: key_of('/secret/_action/cancel_goal', 'action_msgs::srv::dds_::CancelGoal_'),
    Verb.READ: key_of('/secret/get_parameters', 'rcl_interfaces::srv::dds_::GetParameters_'),
    Verb.SET: key_of('/secret/set_parameters', 'rcl_interfaces::srv::dds_::SetParameters_'),
}
"""The service that each of these verbs calls."""

_EVERYONE = '[everyone]\npublish = ["/marker"]\nsubscribe = ["/open"]\n'
_ROBOT = '[roles.robot]\n' + ''.join(f'{verb.value} = ["/**"]\n' for verb in Verb)
_MEMBERS = '[identities]\nsite = []\nrobby = ["robot"]\nann = ["robot"]\nmallory = ["mallory"]\n'


def policy_of(grants: dict[Verb, list[str]], mode: str = 'enforce') -> str:
    """Return a policy by which mallory may do these to names that match the patterns."""
    lines = ''.join(
        f'{verb.value} = [{", ".join(map(repr, patterns))}]\n' for verb, patterns in grants.items()
    )
    return f'mode = "{mode}"\n{_EVERYONE}{_ROBOT}[roles.mallory]\n{lines}{_MEMBERS}'


def node_token(session: str) -> str:
    """Return the token of a node /secret that belongs to a session."""
    return f'@ros2_lv/0/{session}/0/0/NN/%/%/secret'


def files_of(keystore: Keystore, name: str) -> TlsFiles:
    """Return the files of an identity, as a session without a policy takes them."""
    own = str(keystore.identity_path(name))
    return TlsFiles(str(keystore.trust_path), own, own, own, own, True, False)


class Robot(Ours):
    """The session of an identity that keeps the policy of its keystore."""

    def __init__(
        self, keystore: Keystore, name: str = 'robby', connect: tuple[str, ...] = (), *, listens: bool = True
    ) -> None:
        self.where = f'tls/127.0.0.1:{free_port()}'
        settings = Settings(
            listen=(self.where,) if listens else (), connect=connect, tls=files_of(keystore, name)
        )
        self.wire = NativeWire(settings, PolicyEnforcement(Chosen(keystore.path, name)))
        self.session = self.wire.session
        self.protocol = self.session.protocol
        self.id = self.session.id
        self.held = []
        self._publications = {}

    def close(self) -> None:
        self.wire.close()


class Site:
    """A keystore, and the robot and the router of it; all that was opened is closed at the end."""

    def __init__(self, keystore: Keystore, policy: str, stack: ExitStack) -> None:
        self.keystore = keystore
        keystore.policy_path.write_text(policy)
        self._stack = stack
        self.robot = self.keep(Robot(keystore))
        self.robot_heard = self.robot.subscribe(MARKER)
        self._router = ''

    def keep(self, side: Robot) -> Robot:
        """Close a session when the site is closed."""
        self._stack.callback(side.close)
        return side

    def router(self) -> str:
        """Return the address of the router, which keeps the policy; the robot is linked to it."""
        if not self._router:
            port = free_port()
            self._stack.enter_context(router(port, [], [], Chosen(self.keystore.path, 'site')))
            self._router = f'tls/127.0.0.1:{port}'
            self.robot.close()
            self.robot = self.keep(Robot(self.keystore, connect=(self._router,)))
            self.robot_heard = self.robot.subscribe(MARKER)
        return self._router


@contextmanager
def opened(open_side: Callable[[], Side]) -> Iterator[Side | None]:
    """Open a session in the block; None if it gets no link."""
    try:
        side = open_side()
    except (TransportError, zenoh.ZError):
        side = None
    try:
        yield side
    finally:
        if side is not None:
            side.close()


# ---- identities: the files that each shows


def _stolen(keystore: Keystore, name: str) -> TlsFiles:
    """Return the files of an identity, of which a thief has made a copy."""
    copy = keystore.path / f'stolen-{name}.pem'
    if not copy.exists():
        shutil.copy(keystore.identity_path(name), copy)
    own = str(copy)
    return replace(
        files_of(keystore, name),
        connect_certificate=own,
        connect_private_key=own,
        listen_certificate=own,
        listen_private_key=own,
    )


def of_another_authority(keystore: Keystore) -> TlsFiles:
    """Return files with the robot's own name, which an authority of the attacker's has issued."""
    folder = keystore.path.parent / 'other'
    other = Keystore(folder) if folder.exists() else Keystore.create(folder)
    if 'robby' not in other.names():
        other.add('robby', 'robot', ())
    return replace(files_of(other, 'robby'), root_ca_certificate=str(keystore.trust_path))


def _issued_for(keystore: Keystore, name: str, life: timedelta) -> TlsFiles:
    if name not in keystore.names():
        keystore.issue(name, 'program', life)
    return files_of(keystore, name)


def _revoked(keystore: Keystore) -> TlsFiles:
    files = _stolen(keystore, 'mallory')
    keystore.revoke('mallory')
    return files


STRANGERS: dict[str, Callable[[Keystore], TlsFiles]] = {
    'without a certificate': lambda keystore: replace(files_of(keystore, 'mallory'), enable_mtls=False),
    'of another authority': of_another_authority,
    'expired': lambda keystore: _issued_for(keystore, 'late', timedelta(seconds=-1)),
    'revoked': _revoked,
    'not in the policy': lambda keystore: _issued_for(keystore, 'nobody', timedelta(days=1)),
}
"""The strangers who must get no link to a robot, whatever the policy says about mallory."""


# ---- knowing that all has arrived


def exchange(sender: Side, receiver: Side, *keys: str, last: str) -> set[str]:
    """Put on keys again and again until `last`, which is MARKER or OPEN, has come; return the keys that came.

    A message goes the other way first, so that the sender knows of the receiver's subscriptions by then. The
    keys are put before `last` each time, over the same link: so they have come by then, or never will.
    """
    heard = [receiver.subscribe(key) for key in (*keys, last)]
    _pass_one(
        receiver, sender.subscribe(OPEN if last == MARKER else MARKER), OPEN if last == MARKER else MARKER
    )
    _pass_one(sender, heard[-1], *keys, last)
    return {key for each in heard for key, _ in each.samples}


def _pass_one(sender: Side, heard: Heard, *keys: str) -> None:
    """Put on keys until one has come on the last of them; those of earlier exchanges do not count."""
    payload = urandom(8)

    def has_come() -> bool:
        for key in keys:
            sender.put(key, payload)
        return any(each == payload for _, each in heard.samples)

    wait_for(has_come, f'messages on {keys[-1]}')
