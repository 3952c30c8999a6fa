"""A policy as the access control of a Zenoh router: rules on key expressions, bound to names of certificates.

A router checks each message twice: when it arrives on a link, and when it leaves on one. So an identity has
rules for both: if it may publish on a topic, it may put on the topic's keys, and learns of the topic's
subscribers. Keys and types are those of rmw_zenoh; `**` does not cross a chunk that begins with `@`, so that
graph and history have expressions of their own.

Rules that deny always override rules that allow. So "all services, but not those for parameters" becomes a
rule that denies the latter. An identity that may call all services and set the parameters of some nodes only
cannot be expressed. `inexpressible` reports such cases.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import NamedTuple

from goalwire.security.needs import READING, SETTING
from goalwire.security.policy import Grant, Policy, Verb, matches
from goalwire.transport.zenoh.settings.values import Settings
from goalwire.zenoh.protocol.key_expressions import canonical

_MESSAGE, _SERVICE = '$*::msg::dds_::$*', '$*::srv::dds_::$*'
_IN, _OUT = 'ingress', 'egress'
_PUT, _REPLY, _QUERY = ('put', 'delete'), ('reply',), ('query',)
_SUBSCRIBER, _QUERYABLE = ('declare_subscriber',), ('declare_queryable',)
_TOKEN = ('liveliness_token',)
_WATCHING = ('declare_liveliness_subscriber', 'liveliness_query')
_GRAPH = '@ros2_lv'

_REQUESTS = {
    Verb.CALL: (('', _SERVICE),),
    Verb.SEND: (('/_action/send_goal', '*'), ('/_action/get_result', '*')),
    Verb.WATCH: (('/_action/get_result', '*'),),
    Verb.CANCEL: (('/_action/cancel_goal', '*'),),
    Verb.READ: tuple((f'/{each}', _SERVICE) for each in READING),
    Verb.SET: tuple((f'/{each}', _SERVICE) for each in SETTING),
}
"""The services that a verb allows to call: the end of the name, and the type."""
_FEEDS = (('/_action/feedback', '*'), ('/_action/status', '*'))


class Rule(NamedTuple):
    """Messages on keys that are allowed or denied in one direction."""

    flow: str
    messages: tuple[str, ...]
    key: str
    permission: str = 'allow'


class _Narrower(NamedTuple):
    """A verb whose keys are also covered by a wider verb, but which the wider verb must not grant."""

    wide: Verb
    narrow: Verb
    suffix: str
    example: str
    flow: str
    messages: tuple[str, ...]


_NARROWER = (
    *(
        _Narrower(Verb.CALL, narrow, suffix, f'/x{suffix}', _IN, _QUERY)
        for narrow in (Verb.CANCEL, Verb.READ, Verb.SET)
        for suffix, _ in _REQUESTS[narrow]
    ),
    _Narrower(Verb.PUBLISH, Verb.SERVE, '/_action/status', '/x/_action/status', _IN, _PUT),
    _Narrower(Verb.SUBSCRIBE, Verb.WATCH, '/_action/status', '/x/_action/status', _OUT, _PUT),
)


def _paths(grant: Grant) -> Iterator[str]:
    """Yield the beginnings of the keys of a grant's names, one for each domain."""
    path = '/'.join(
        chunk if chunk in {'*', '**'} else chunk.replace('*', '$*') for chunk in grant.pattern.split('/')[1:]
    )
    for domain in grant.domains or ('*',):
        yield f'{domain}/{path}'


def _mangle(pattern: str) -> list[str]:
    """Return expressions for the chunk of a token that holds a name, in which '%' replaces each slash.

    No wildcard inside a chunk stands for "one or more characters except '%'". So '/*/b' matches also the
    token of /x/y/b, and the namespace '/*' matches also the empty one. This affects only tokens; the keys of
    data have slashes. `inexpressible` reports it.
    """
    found = ['']
    for chunk in pattern.split('/')[1:]:
        if chunk == '**':
            found += [f'{each}%$*' for each in found]
        else:
            found = [f'{each}%{chunk.replace("*", "$*")}' for each in found]
    return [each or '%' for each in found]


def _tokens(grant: Grant, codes: str, suffix: str = '') -> Iterator[str]:
    """Yield the key expressions of the liveliness tokens of endpoints whose names a grant covers."""
    for domain in grant.domains or ('*',):
        for code in codes.split():
            for name in _mangle(grant.pattern + suffix):
                yield f'{_GRAPH}/{domain}/*/*/*/{code}/*/*/*/{name}/**'


def _nodes(grant: Grant, codes: str = '*') -> Iterator[str]:
    """Yield the key expressions of the liveliness tokens of a grant's nodes, and of their endpoints."""
    space, _, name = grant.pattern.rpartition('/')
    places = [(namespace, name.replace('*', '$*') if name != '*' else '*') for namespace in _mangle(space)]
    if name == '**':
        below = [namespace for each in _mangle(space) for namespace in (each, f'{each.rstrip("%")}%$*')]
        places = [(namespace, '*') for namespace in below]
        if space:  # /arm/** covers the node /arm, too
            above, _, own = space.rpartition('/')
            places += [(namespace, own.replace('*', '$*')) for namespace in _mangle(above)]
    for domain in grant.domains or ('*',):
        for namespace, node in places:
            yield f'{_GRAPH}/{domain}/*/*/*/{codes}/*/{namespace}/{node}/**'


def _topic_rules(path: str, type_: str, *, publishes: bool) -> Iterator[Rule]:
    """Return the rules of a topic: for its messages, for kept messages, and for its subscribers."""
    key = canonical(f'{path}/{type_}/*')
    history = canonical(f'{path}/{type_}/*/@adv/**')
    sends, hears = (_IN, _OUT) if publishes else (_OUT, _IN)
    yield Rule(sends, (*_PUT, *_REPLY), key)
    yield Rule(hears, _SUBSCRIBER, key)
    yield Rule(sends, (*_QUERYABLE, *_REPLY), history)
    yield Rule(sends, _TOKEN, canonical(f'{path}/{type_}/*/@adv/pub/**'))
    yield Rule(hears, (*_QUERY, *_WATCHING), history)
    yield Rule(hears, _TOKEN, canonical(f'{path}/{type_}/*/@adv/sub/**'))


def _service_rules(path: str, type_: str, *, serves: bool) -> Iterator[Rule]:
    key = canonical(f'{path}/{type_}/*')
    answers, asks = (_IN, _OUT) if serves else (_OUT, _IN)
    yield Rule(answers, (*_QUERYABLE, *_REPLY), key)
    yield Rule(asks, _QUERY, key)


def _rules_of(grant: Grant) -> Iterator[Rule]:
    """Return the rules that a grant needs."""
    verb = grant.verb
    if verb is Verb.RUN:
        yield from (Rule(_IN, _TOKEN, key) for key in _nodes(grant, 'NN'))
    if verb is Verb.INTROSPECT:
        yield from (Rule(_OUT, _TOKEN, key) for key in _nodes(grant))
        yield from (Rule(_OUT, _TOKEN, key) for key in _tokens(grant, 'MP MS SS SC'))
    for path in _paths(grant):
        if verb in {Verb.PUBLISH, Verb.SUBSCRIBE}:
            yield from _topic_rules(path, _MESSAGE, publishes=verb is Verb.PUBLISH)
        for suffix, type_ in _REQUESTS.get(verb, ()):
            yield from _service_rules(path + suffix, type_, serves=False)
        if verb in {Verb.SEND, Verb.WATCH}:
            for suffix, type_ in _FEEDS:
                yield from _topic_rules(path + suffix, type_, publishes=False)
        if verb is Verb.SERVE:
            yield from _service_rules(path, _SERVICE, serves=True)
            for suffix in ('send_goal', 'get_result', 'cancel_goal'):
                yield from _service_rules(f'{path}/_action/{suffix}', '*', serves=True)
            for suffix, type_ in _FEEDS:
                yield from _topic_rules(path + suffix, type_, publishes=True)
    yield from _token_rules(grant)


def _token_rules(grant: Grant) -> Iterator[Rule]:
    """Return the rules for endpoints' tokens: the owner declares them, and the other side sees them."""
    offers = {Verb.PUBLISH: ('MP', 'MS', ('',)), Verb.SERVE: ('SS MP', 'SC MS', ('', '/_action/*'))}
    uses: dict[Verb, tuple[str, str, tuple[str, ...]]] = {
        Verb.SUBSCRIBE: ('MS', 'MP', ('',)),
        Verb.WATCH: ('MS SC', 'MP SS', tuple(suffix for suffix, _ in (*_FEEDS, *_REQUESTS[Verb.WATCH]))),
        Verb.SEND: ('MS SC', 'MP SS', tuple(suffix for suffix, _ in (*_FEEDS, *_REQUESTS[Verb.SEND]))),
        **{
            verb: ('SC', 'SS', tuple(suffix for suffix, _ in _REQUESTS[verb]))
            for verb in (Verb.CALL, Verb.CANCEL, Verb.READ, Verb.SET)
        },
    }
    own, others, suffixes = (offers | uses).get(grant.verb, ('', '', ()))
    for suffix in suffixes:
        for key in _tokens(grant, own, suffix):
            yield Rule(_IN, _TOKEN, key)
        for key in _tokens(grant, others, suffix):
            yield Rule(_OUT, _TOKEN, key)


def _denials(grants: tuple[Grant, ...]) -> Iterator[tuple[_Narrower, Rule]]:
    """Yield the rules that deny keys which a wider grant would allow."""
    for each in _NARROWER:
        is_covered = any(
            grant.verb is each.wide and _could_cover(grant.pattern, each.suffix) for grant in grants
        )
        has_all = any(
            grant.verb is each.narrow and grant.pattern == '/**' and not grant.domains for grant in grants
        )
        if is_covered and not has_all:
            key = canonical(f'*/**{each.suffix}/*/*')
            yield each, Rule(each.flow, each.messages, key, 'deny')


def _could_cover(pattern: str, suffix: str) -> bool:
    """Return whether a pattern matches at least one name that ends with `suffix`."""
    last = pattern.rpartition('/')[2]
    return last == '**' or matches(f'/{last}', f'/{suffix.rpartition("/")[2]}')


_SEEN = (Verb.RUN, Verb.INTROSPECT)
"""The verbs that concern only tokens."""


def inexpressible(policy: Policy) -> list[str]:
    """Return sentences about acts that only one of policy and router rules allows."""
    found = []
    for who, grants in policy.grants.items():
        found += [
            f"a router lets '{who}' {grant.verb.value} more names than {grant.pattern}: in its rules for the "
            f"graph '*' also stands for no part of a name, and for several"
            for grant in grants
            if grant.verb in _SEEN and any('*' in chunk != '**' for chunk in grant.pattern.split('/')[1:-1])
        ]
        for narrower, _ in _denials(grants):
            if any(grant.verb is narrower.narrow for grant in grants):
                found.append(
                    f"a router refuses '{who}' to {narrower.narrow.value} by way of {narrower.suffix}, since "
                    f'its rules cannot take that out of {narrower.wide.value} for some names only: '
                    f'narrow {narrower.wide.value}, or write {narrower.narrow.value} = ["/**"]'
                )
    return found


def access_control(policy: Policy, revoked: Collection[str]) -> Settings:
    """Return the settings `access_control` of a router, goalwire's or rmw_zenoh's.

    A router knows names, but not when a certificate was issued. So a revoked name may do nothing through a
    router, even with a new certificate, until it is removed from the list.
    """
    rules: list[Settings] = []
    policies: list[Settings] = []
    subjects: list[Settings] = []
    for who, grants in policy.grants.items():
        if who in revoked:
            continue
        subjects.append({'id': who, 'cert_common_names': [who]})
        merged: dict[tuple[str, tuple[str, ...], str], dict[str, None]] = {}
        wanted = [rule for grant in grants for rule in _rules_of(grant)]
        wanted += [rule for _, rule in _denials(grants)]
        wanted += _always()
        for rule in wanted:
            merged.setdefault((rule.flow, rule.messages, rule.permission), {})[rule.key] = None
        names = []
        for number, ((flow, messages, permission), keys) in enumerate(merged.items()):
            name = f'{who} {number}'
            names.append(name)
            rules.append(
                {
                    'id': name,
                    'permission': permission,
                    'flows': [flow],
                    'messages': list(messages),
                    'key_exprs': list(keys),
                }
            )
        policies.append({'rules': list(names), 'subjects': [who]})
    return {
        'enabled': policy.is_enforced,
        'default_permission': 'deny',
        'rules': list(rules),
        'subjects': list(subjects),
        'policies': list(policies),
    }


def _always() -> list[Rule]:
    """Return the rules for every identity: it may ask for tokens, and receives those that it may see."""
    keys = ('**', f'{_GRAPH}/**', '**/@adv/**')
    return [Rule(flow, _WATCHING, key) for flow in (_IN, _OUT) for key in keys]
