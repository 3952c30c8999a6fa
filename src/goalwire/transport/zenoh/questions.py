"""The meaning of ROS's keys on Zenoh for a policy: the verbs and names that allow an act on a key.

Topics, services and the parts of actions have keys of one form; the DDS type in a key tells them apart. What
is not of ROS's form is nothing that a policy can allow.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from goalwire.errors import RemoteError
from goalwire.security.policy import Verb
from goalwire.transport.contract import EndpointKind, GraphEntity
from goalwire.transport.zenoh.tokens import GRAPH_SPACE, dds_type, parse
from goalwire.zenoh.protocol.guard import Act

CERTIFICATE = '@goalwire/certificate/'
"""Stands before a session's id in the key on which others show it their renewed certificates."""
HISTORY = '/@adv/'
"""Stands behind a topic's key in the keys by which its publishers show and tell what they keep."""

_SUBSCRIBER = 'sub'
"""Stands there in the token of a subscription with history; in a publisher's it is 'pub'."""
_LEAST_CHUNKS = 4
_PART = '/_action/'
_READING = ('get_parameters', 'get_parameter_types', 'list_parameters', 'describe_parameters')
_SETTING = ('set_parameters', 'set_parameters_atomically')
_REQUESTS = ('_SendGoal_', '_GetResult_')
"""How the types of an action's own services end; that of its cancelling is an ordinary service type."""
_OF_ACTIONS = {
    'send_goal': (Verb.SEND,),
    'cancel_goal': (Verb.CANCEL,),
    'get_result': (Verb.SEND, Verb.WATCH),
    'feedback': (Verb.SEND, Verb.WATCH),
    'status': (Verb.SEND, Verb.WATCH),
}


class Question(NamedTuple):
    """One of several ways to be allowed: any of these verbs on a name in a domain."""

    verbs: tuple[Verb, ...]
    name: str
    domain: int


Questions: TypeAlias = tuple[Question, ...] | None
"""All must be answered with yes; None: nothing can allow it."""


class _Subject(NamedTuple):
    """The subject of a data key."""

    domain: int
    name: str
    is_service: bool

    @property
    def action(self) -> tuple[str, str]:
        """The action that it is a part of, and which part; empty if it is not."""
        name, found, part = self.name.rpartition(_PART)
        return (name, part) if found and part in _OF_ACTIONS else ('', '')


def _subject_of(key: str) -> _Subject | None:
    chunks = key.partition(HISTORY)[0].split('/')
    if len(chunks) < _LEAST_CHUNKS or '*' in key.partition(HISTORY)[0] or not chunks[0].isdecimal():
        return None
    return _subject(int(chunks[0]), '/' + '/'.join(chunks[1:-2]), chunks[-2])


def _subject(domain: int, name: str, dds_type: str) -> _Subject:
    return _Subject(domain, name, '::srv::' in dds_type or dds_type.endswith(_REQUESTS))


def _offering(subject: _Subject) -> Question:
    """Ask whether somebody may publish on a topic, or answer a service."""
    action, _ = subject.action
    if action:
        return Question((Verb.SERVE,), action, subject.domain)
    verb = Verb.SERVE if subject.is_service else Verb.PUBLISH
    return Question((verb,), subject.name, subject.domain)


def _using(subject: _Subject) -> Question:
    """Ask whether an identity may receive a topic's messages, or call a service."""
    action, part = subject.action
    if action:
        return Question(_OF_ACTIONS[part], action, subject.domain)
    if not subject.is_service:
        return Question((Verb.SUBSCRIBE,), subject.name, subject.domain)
    node, _, service = subject.name.rpartition('/')
    if node and service in _READING:
        return Question((Verb.READ,), node, subject.domain)
    if node and service in _SETTING:
        return Question((Verb.SET,), node, subject.domain)
    return Question((Verb.CALL,), subject.name, subject.domain)


_USERS = (EndpointKind.SUBSCRIPTION, EndpointKind.CLIENT)


def _of_token(token: str, session: str, *, learns: bool) -> tuple[Questions, Questions]:
    """Return what a token's owner must be allowed, and what another identity needs to see the token: one
    of these.
    """
    try:
        entity = parse(token)
        domain = int(token.split('/')[1])
    except (RemoteError, ValueError):
        return None, None
    if not learns and entity.session != session:
        return None, None  # the token is declared in another session's name
    node = entity.node.qualified
    runs = Question((Verb.RUN,), node, domain)
    looks = Question((Verb.INTROSPECT,), node, domain)
    if entity.kind is EndpointKind.NODE:
        return (runs,), (looks,)
    chunks = token.split('/')
    subject = _subject(domain, entity.name, chunks[10])
    offers, uses = _offering(subject), _using(subject)
    if entity.kind in _USERS:
        return (runs, uses), (looks, offers)
    return (runs, offers), (looks, uses, offers._replace(verbs=(Verb.INTROSPECT,)))


def need_of(entity: GraphEntity) -> Question:
    """Return the need of an endpoint's owner; for an action's feedback or result, the need to watch it."""
    subject = _subject(0, entity.name, dds_type(entity.type_name))
    wanted = _using(subject) if entity.kind in _USERS else _offering(subject)
    if Verb.WATCH in wanted.verbs and subject.action[1] != 'send_goal':
        return wanted._replace(verbs=(Verb.WATCH,))
    return wanted


_DATA: dict[Act, Callable[[_Subject], Question]] = {
    Act.PUT: _offering,
    Act.REPLY: _offering,
    Act.DECLARE_QUERYABLE: _offering,
    Act.QUERY: _using,
    Act.DECLARE_SUBSCRIBER: _using,
    Act.RECEIVE: _using,
    Act.LEARN_SUBSCRIBER: _offering,
    Act.LEARN_QUERYABLE: _using,
}


def is_of_links(act: Act, key: str, session: str) -> bool:
    """Whether an act serves the link itself, so that no policy need allow it: `session` is at its other end.

    Anybody may show a certificate to this session, and receives those that are shown to itself, but no other.
    """
    if not key.startswith(CERTIFICATE):
        return False
    return act in _SHOWING or key == CERTIFICATE + session


def all_of(act: Act, key: str, session: str) -> Questions:
    """Return the questions that must all be answered with yes; none for what is only seen in the graph."""
    if act is Act.DECLARE_TOKEN:
        if key.startswith(f'{GRAPH_SPACE}/'):
            return _of_token(key, session, learns=False)[0]
        subject = _subject_of(key)
        side, owner = [*key.partition(HISTORY)[2].split('/'), '', ''][:2]
        if subject is None or owner != session:
            return None
        return (_using(subject) if side == _SUBSCRIBER else _offering(subject),)
    subject = _subject_of(key)
    return None if subject is None else (_DATA[act](subject),)


def any_of(act: Act, key: str, session: str) -> Questions:
    """Return the questions of which one must be answered with yes before something is shown."""
    if act is Act.LEARN_TOKEN and key.startswith(f'{GRAPH_SPACE}/'):
        return _of_token(key, session, learns=True)[1]
    subject = _subject_of(key)
    if subject is None:
        return None
    if act is Act.LEARN_TOKEN:
        is_subscriber = key.partition(HISTORY)[2].startswith(f'{_SUBSCRIBER}/')
        return (_offering(subject) if is_subscriber else _using(subject),)
    wanted = _DATA[act](subject)
    action, _ = subject.action
    looks = Question((Verb.INTROSPECT,), action or subject.name, subject.domain)
    # A service is told to those who see it, so that a call of it is refused, and does not wait for it.
    return (wanted, looks) if act is Act.LEARN_QUERYABLE else (wanted,)


_SHOWING = (Act.PUT, Act.LEARN_SUBSCRIBER)
LEARNING = (Act.LEARN_SUBSCRIBER, Act.LEARN_QUERYABLE, Act.LEARN_TOKEN)
