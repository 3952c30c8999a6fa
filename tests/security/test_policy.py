"""The permissions of a policy, also compared with a model that was written independently of it."""

from __future__ import annotations

from fnmatch import fnmatchcase

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from goalwire.security.policy import Grant, Policy, Verb, matches
from goalwire.security.policy_file import read_policy

EXAMPLE = """
[everyone]
publish = ["/rosout"]

[roles.operator]
call = ["/reset", "/arm/**"]
send = ["/walk"]

[roles.mapper]
namespace = "/robot1"
domains = [7]
subscribe = ["scan", "/tf"]

[identities]
alice = ["operator"]
bob = ["mapper", "operator"]
"""


@pytest.mark.parametrize(
    ('who', 'verb', 'name', 'domain', 'is_allowed'),
    [
        ('alice', Verb.CALL, '/reset', 0, True),
        ('alice', Verb.CALL, '/reset/it', 0, False),
        ('alice', Verb.CALL, '/arm/left/move', 0, True),
        ('alice', Verb.CALL, '/army', 0, False),
        ('alice', Verb.SEND, '/walk', 0, True),
        ('alice', Verb.CANCEL, '/walk', 0, False),
        ('alice', Verb.PUBLISH, '/rosout', 3, True),
        ('bob', Verb.SUBSCRIBE, '/robot1/scan', 7, True),
        ('bob', Verb.SUBSCRIBE, '/robot1/scan', 0, False),
        ('bob', Verb.SUBSCRIBE, '/scan', 7, False),
        ('bob', Verb.SUBSCRIBE, '/tf', 7, True),
        ('mallory', Verb.PUBLISH, '/rosout', 0, False),
    ],
)
def test_nothing_is_allowed_that_no_line_allows(
    who: str, verb: Verb, name: str, domain: int, is_allowed: bool
) -> None:
    assert read_policy(EXAMPLE).decide(who, verb, name, domain).is_allowed is is_allowed


def test_an_answer_names_the_line_that_decides() -> None:
    policy = read_policy(EXAMPLE)
    assert policy.decide('alice', Verb.CALL, '/arm/x').reason == 'policy.toml:6: operator: call /arm/**'
    assert policy.decide('bob', Verb.SUBSCRIBE, '/tf', 0).reason == (
        "policy.toml:16: none of the roles of 'bob' may subscribe '/tf'"
    )
    assert policy.decide('mallory', Verb.CALL, '/reset').reason == (
        "policy.toml: [identities] does not name 'mallory'"
    )


# ---- a model: names are cut into parts, and the parts are compared one after the other


def _fits(pattern: list[str], name: list[str]) -> bool:
    if not pattern:
        return not name
    first, *rest = pattern
    if first == '**':
        return any(_fits(rest, name[count:]) for count in range(len(name) + 1))
    return bool(name) and fnmatchcase(name[0], first) and _fits(rest, name[1:])


_PARTS = st.sampled_from(['a', 'b', 'ab', 'arm'])
_NAMES = st.lists(_PARTS, min_size=1, max_size=4).map(lambda parts: '/' + '/'.join(parts))
_PATTERNS = st.lists(
    st.sampled_from(['a', 'b', 'ab', '*', '**', 'a*', '*b', '*r*']), min_size=1, max_size=4
).map(lambda parts: '/' + '/'.join(parts))
_DOMAINS = st.lists(st.integers(0, 3), max_size=2)
_ROLES = st.lists(st.tuples(st.sampled_from(list(Verb)), _PATTERNS, _DOMAINS), max_size=4)


@settings(max_examples=300, deadline=None)
@given(_PATTERNS, _NAMES)
def test_patterns_match_as_the_model_says(pattern: str, name: str) -> None:
    assert matches(pattern, name) is _fits(pattern.split('/')[1:], name.split('/')[1:])


@settings(max_examples=300, deadline=None)
@given(
    st.lists(_ROLES, min_size=1, max_size=3),
    st.dictionaries(st.sampled_from(['ann', 'ben']), st.sets(st.integers(0, 2))),
    st.lists(st.tuples(st.sampled_from(['ann', 'ben', 'eve']), st.sampled_from(list(Verb)), _NAMES)),
    st.integers(0, 3),
)
def test_written_policies_decide_as_the_model_says(
    roles: list[list[tuple[Verb, str, list[int]]]],
    members: dict[str, set[int]],
    questions: list[tuple[str, Verb, str]],
    domain: int,
) -> None:
    lines = []
    for at, grants in enumerate(roles):
        for number, (verb, pattern, domains) in enumerate(grants):
            lines += [f'[roles.r{at}_{number}]', f'domains = {domains}', f'{verb.value} = ["{pattern}"]']
    lines.append('[identities]')
    for who, which in members.items():
        names = [f'"r{at}_{number}"' for at in which if at < len(roles) for number in range(len(roles[at]))]
        lines.append(f'{who} = [{", ".join(names)}]')
    policy = read_policy('\n'.join(lines))
    for who, verb, name in questions:
        expected = any(
            verb is granted and _fits(pattern.split('/')[1:], name.split('/')[1:])
            for at in members.get(who, ())
            if at < len(roles)
            for granted, pattern, domains in roles[at]
            if not domains or domain in domains
        )
        assert policy.decide(who, verb, name, domain).is_allowed is expected


def test_a_policy_without_a_file_is_a_value() -> None:
    grant = Grant(Verb.CALL, '/x')
    assert Policy('enforce', {'ann': (grant,)}).decide('ann', Verb.CALL, '/x').is_allowed
