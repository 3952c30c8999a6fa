"""The meaning of ROS's keys on Zenoh for a policy: the verbs and names that allow an act on a key.

Topics, services and the parts of actions have keys of one form; the DDS type in a key tells them apart. A
policy cannot allow keys of another form.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from goalwire.errors import RemoteError
from goalwire.security.needs import permission_to_offer, permission_to_use, split_action
from goalwire.security.policy import Verb
from goalwire.transport.contract import EndpointKind, GraphEntity
from goalwire.transport.zenoh.ros_keys import GRAPH_SPACE, dds_type, parse
from goalwire.zenoh.protocol.guard import Act

CERTIFICATE = '@goalwire/certificate/'
"""The prefix of the key on which a session receives renewed certificates; the session's id follows."""
HISTORY = '/@adv/'
"""The part after a topic's key in the keys with which publishers announce and serve their history."""

_SUBSCRIBER = 'sub'
"""The next part in the token of a subscription with history; a publisher's token has 'pub'."""
_LEAST_CHUNKS = 4
_REQUESTS = ('_SendGoal_', '_GetResult_')
"""The endings of an action's own service types. The type of the cancel service is an ordinary one."""


class Question(NamedTuple):
    """A question to a policy: is any of these verbs allowed on a name in a domain?"""

    verbs: tuple[Verb, ...]
    name: str
    domain: int


Questions: TypeAlias = tuple[Question, ...] | None
"""Several questions; None if no policy can allow the act."""


class _Subject(NamedTuple):
    """The subject of a data key."""

    domain: int
    name: str
    is_service: bool

    @property
    def action(self) -> tuple[str, str]:
        """The action that the key is about, and the part of the action ('feedback'); '' and '' if none."""
        return split_action(self.name)


def _subject_of(key: str) -> _Subject | None:
    chunks = key.partition(HISTORY)[0].split('/')
    if len(chunks) < _LEAST_CHUNKS or '*' in key.partition(HISTORY)[0] or not chunks[0].isdecimal():
        return None
    return _subject(int(chunks[0]), '/' + '/'.join(chunks[1:-2]), chunks[-2])


def _subject(domain: int, name: str, dds_type: str) -> _Subject:
    return _Subject(domain, name, '::srv::' in dds_type or dds_type.endswith(_REQUESTS))


def _offering(subject: _Subject) -> Question:
    """Return the question whether an identity may publish on a topic, or serve a service."""
    return Question(*permission_to_offer(subject.name, is_service=subject.is_service), subject.domain)


def _using(subject: _Subject) -> Question:
    """Return the question whether an identity may receive a topic's messages, or call a service."""
    return Question(*permission_to_use(subject.name, is_service=subject.is_service), subject.domain)


_USERS = (EndpointKind.SUBSCRIPTION, EndpointKind.CLIENT)


def _of_token(token: str, session: str, *, learns: bool) -> tuple[Questions, Questions]:
    """Return the questions for a token's owner (all), and for another identity that sees it (any)."""
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
    """Return what the policy must allow the owner of an endpoint.

    To read an action's feedback or results, WATCH is enough.
    """
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
    """Return whether an act only shows certificates, which needs no permission; `session` is the peer.

    Every peer may show a certificate to this session, and receives only those that are shown to itself.
    """
    if not key.startswith(CERTIFICATE):
        return False
    return act in _SHOWING or key == CERTIFICATE + session


def all_of(act: Act, key: str, session: str) -> Questions:
    """Return the questions that must all be answered with yes before an act is allowed."""
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


def describe(act: Act, key: str) -> str:
    """Return an act in a policy's words, such as "call /reset"; the key if no policy has words for it."""
    if act is Act.DECLARE_TOKEN and key.startswith(f'{GRAPH_SPACE}/'):
        try:
            entity = parse(key)
        except (RemoteError, ValueError):
            return f'{act.value} that is malformed'
        if entity.kind is EndpointKind.NODE:
            return f'{Verb.RUN.value} {entity.node.qualified}'
        asked: Questions = (need_of(entity),)
    else:
        asked = all_of(act, key, '')
    return f'{asked[0].verbs[0].value} {asked[0].name}' if asked else f'{act.value} {key}'


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
    # Whoever may see a service learns of it, so that a forbidden call is refused instead of waiting.
    return (wanted, looks) if act is Act.LEARN_QUERYABLE else (wanted,)


_SHOWING = (Act.PUT, Act.LEARN_SUBSCRIBER)
LEARNING = (Act.LEARN_SUBSCRIBER, Act.LEARN_QUERYABLE, Act.LEARN_TOKEN)
