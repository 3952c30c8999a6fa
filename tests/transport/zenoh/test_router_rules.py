"""A policy as rules of a router: they let through what the policy allows, but for what `inexpressible` tells.

The rules are judged here as Zenoh's router judges them (zenoh `net/routing/interceptor/authorization.rs`): a
rule is about a message if one of its expressions includes the message's key; denials come first.
"""

from __future__ import annotations

from random import Random
from typing import NamedTuple

import pytest
import zenoh

from goalwire.security.policy import Policy, Verb
from goalwire.security.policy_file import read_policy
from goalwire.transport.zenoh.router_rules import access_control, inexpressible

SESSION = '1234'
TYPES = {'msg': 'std_msgs::msg::dds_::String_', 'srv': 'std_srvs::srv::dds_::Empty_'}


class Probe(NamedTuple):
    """A message on its way into a router, or out of it, and the verbs of which one allows it."""

    flow: str
    message: str
    key: str
    verbs: tuple[Verb, ...]
    name: str


def _data(name: str, kind: str) -> str:
    return f'0{name}/{TYPES.get(kind, kind)}/RIHS01_00'


def _token(code: str, node: str, name: str = '', dds_type: str = '') -> str:
    space, _, own = node.rpartition('/')
    mangled = space.replace('/', '%') or '%'
    end = f'/{name.replace("/", "%")}/{dds_type}/RIHS01_00/:,:,:,:,,' if name else ''
    return f'@ros2_lv/0/{SESSION}/0/1/{code}/%/{mangled}/{own}{end}'


def probes(name: str) -> list[Probe]:
    """Return messages of each verb about a name."""
    goal, result = (f'{name}/_action/{each}' for each in ('send_goal', 'get_result'))
    send, get = 'a::action::dds_::Walk_SendGoal_', 'a::action::dds_::Walk_GetResult_'
    cancel = 'action_msgs::srv::dds_::CancelGoal_'
    feedback, fed = f'{name}/_action/feedback', 'a::action::dds_::Walk_FeedbackMessage_'
    topic, service = _data(name, 'msg'), _data(name, 'srv')
    return [
        Probe('ingress', 'put', topic, (Verb.PUBLISH,), name),
        Probe('egress', 'put', topic, (Verb.SUBSCRIBE,), name),
        Probe('ingress', 'declare_subscriber', topic, (Verb.SUBSCRIBE,), name),
        Probe('egress', 'declare_subscriber', topic, (Verb.PUBLISH,), name),
        Probe('ingress', 'query', f'{topic}/@adv/pub/1/2/_', (Verb.SUBSCRIBE,), name),
        Probe('ingress', 'reply', f'{topic}/@adv/pub/1/2/_', (Verb.PUBLISH,), name),
        Probe('ingress', 'liveliness_token', f'{topic}/@adv/pub/1/2/_', (Verb.PUBLISH,), name),
        Probe('egress', 'liveliness_token', f'{topic}/@adv/pub/1/2/_', (Verb.SUBSCRIBE,), name),
        Probe('ingress', 'query', service, (Verb.CALL,), name),
        Probe('egress', 'query', service, (Verb.SERVE,), name),
        Probe('ingress', 'declare_queryable', service, (Verb.SERVE,), name),
        Probe('ingress', 'query', _data(goal, send), (Verb.SEND,), name),
        Probe('ingress', 'query', _data(result, get), (Verb.SEND, Verb.WATCH), name),
        Probe('ingress', 'query', _data(f'{name}/_action/cancel_goal', cancel), (Verb.CANCEL,), name),
        Probe('ingress', 'query', _data(f'{name}/get_parameters', 'srv'), (Verb.READ,), name),
        Probe('ingress', 'query', _data(f'{name}/set_parameters', 'srv'), (Verb.SET,), name),
        Probe(
            'egress', 'query', _data(f'{name}/set_parameters', 'srv'), (Verb.SERVE,), f'{name}/set_parameters'
        ),
        Probe('egress', 'put', _data(feedback, fed), (Verb.SEND, Verb.WATCH), name),
        Probe('ingress', 'put', _data(feedback, fed), (Verb.SERVE,), name),
        Probe('ingress', 'liveliness_token', _token('NN', name), (Verb.RUN,), name),
        Probe('egress', 'liveliness_token', _token('NN', name), (Verb.INTROSPECT,), name),
    ]


PROBES = [probe for name in ('/a', '/b', '/a/b', '/a/b/ab') for probe in probes(name)]
KEYS = {probe.key: zenoh.KeyExpr(probe.key) for probe in PROBES}


class Rules:
    """The access control of one identity, judged as a router judges it."""

    def __init__(self, policy: Policy) -> None:
        found = access_control(policy, ())
        rules = found['rules']
        assert isinstance(rules, list)
        self._rules: dict[tuple[str, str], list[tuple[bool, list[zenoh.KeyExpr]]]] = {}
        for rule in rules:
            assert isinstance(rule, dict)
            keys = [zenoh.KeyExpr(str(key)) for key in _texts(rule['key_exprs'])]
            for flow in _texts(rule['flows']):
                for message in _texts(rule['messages']):
                    is_denied = rule['permission'] == 'deny'
                    self._rules.setdefault((flow, message), []).append((is_denied, keys))

    def allow(self, probe: Probe) -> bool:
        """Whether a router lets a message through."""
        key = KEYS[probe.key]
        met = [
            is_denied
            for is_denied, keys in self._rules.get((probe.flow, probe.message), ())
            if any(each.includes(key) for each in keys)
        ]
        return bool(met) and not any(met)


def _texts(found: object) -> list[str]:
    assert isinstance(found, list)
    return list(map(str, found))


_PATTERNS = ('/a', '/b', '/a/b', '/a/*', '/*', '/*/b', '/**', '/a/**', '/**/b', '/a*', '/*b', '/a/b/*')


def draw_policy(random: Random) -> Policy:
    """Return a policy of one identity."""
    text = '[roles.some]\n'
    for verb in Verb:
        patterns = random.sample(_PATTERNS, random.choice((0, 1, 1, 2)))
        text += f'{verb.value} = [{", ".join(map(repr, patterns))}]\n'
    return read_policy(f'{text}[identities]\nann = ["some"]\n')


def _is_told(policy: Policy, probe: Probe, *, is_let_through: bool) -> bool:
    """Whether `inexpressible` tells that a router is stricter here, or lets more through."""
    words = 'lets' if is_let_through else 'refuses'
    to = '' if is_let_through else 'to '
    return any(
        each.startswith(f"a router {words} 'ann' {to}{verb.value} ")
        for each in inexpressible(policy)
        for verb in probe.verbs
    )


def _check(seed: int) -> None:
    policy = draw_policy(Random(seed))
    rules = Rules(policy)
    for probe in PROBES:
        says = any(policy.decide('ann', verb, probe.name).is_allowed for verb in probe.verbs)
        does = rules.allow(probe)
        if does is not says and not _is_told(policy, probe, is_let_through=does):
            grants = [f'{each.verb.value} {each.pattern}' for each in policy.grants['ann']]
            pytest.fail(f'seed {seed}: {probe} is {"let through" if does else "refused"}; {grants}')


def test_a_router_lets_through_what_the_policy_allows() -> None:
    for seed in range(20):
        _check(seed)


@pytest.mark.long
@pytest.mark.slow
def test_a_router_lets_through_what_a_thousand_policies_allow() -> None:
    for seed in range(1000):
        _check(seed)
