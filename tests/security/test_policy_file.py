"""Mistakes in a policy.toml: each is told with its line, its column, and what to write."""

from __future__ import annotations

import tomllib
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import PolicyError
from goalwire.security.policy import Verb
from goalwire.security.policy_file import read_policy
from goalwire.security.policy_text import FIRST_POLICY, add_identity
from goalwire.security.toml_places import Place, find_places


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('mode = "enforced"', '1:1: mode is \'enforced\'; write mode = "enforce" or mode = "audit"'),
        ('mode = ', '1:8: this is not TOML: Invalid value; see: toml.io'),
        ('\n[role.a]\n', "2:1: 'role' is not known here; did you mean 'roles'?"),
        ('[roles.a]\ncall = "/x"', '2:1: call takes a list of texts, not \'/x\'; write call = ["/name"]'),
        ('[roles.a]\n  cal = []', "2:3: 'cal' is not a verb; did you mean 'call' or 'cancel'?"),
        (
            '[roles.a]\ncall = [\n  "/x",  # the first\n  "y",\n]',
            "4:3: 'y' has no slash at its beginning; write '/y'",
        ),
        ('[roles.a]\ncall = [1]', '2:9: 1 is not a text; write call = ["/name"]'),
        ('[roles.a]\ncall = ["/x", "/a**"]', "2:15: '/a**' is not a pattern of names; write letters"),
        ('[roles.a]\ncall = ["/x/"]', "2:9: '/x/' is not a pattern of names"),
        ('[roles.a]\ndomains = [233]', '2:1: 233 is not a domain; write numbers from 0 to 232'),
        ('[roles.a]\nnamespace = "x"', "2:1: 'x' is not a namespace"),
        (
            '[roles.a]\n[identities]\nann = ["b"]',
            "3:8: there is no role 'b'; add [roles.b], or take one of a",
        ),
        ('[roles.a]\nstop = true', '2:1: stop is True; leave it out, since everybody may stop'),
        ('[moving]\nstop = false', '2:1: stop is not a verb; write it into [everyone] or a role'),
        ('[moving]\nmissions = true', '2:1: missions is not a verb; write it into [everyone] or a role'),
        ('[roles.a]\nmissions = false', '2:1: missions is False; leave it out, since nobody may without it'),
        ('[everyone]\nmissions = ["/m"]', "2:1: missions is ['/m']; leave it out"),
        ('[roles.a]\nmission = true', "2:1: 'mission' is not a verb; did you mean 'missions'?"),
        ('[moving]\npublish = ["x"]', "2:12: 'x' has no slash at its beginning"),
        ('identities = 3', '1:1: identities is not a table; write [identities] in a line of its own'),
    ],
)
def test_a_mistake_is_told_with_its_place(text: str, message: str) -> None:
    with pytest.raises(PolicyError) as caught:
        read_policy(text)
    assert str(caught.value).startswith(f'policy.toml:{message}')


def test_what_moves_has_a_default_for_each_verb() -> None:
    policy = read_policy('[moving]\npublish = ["/base/twist_cmd"]\ncall = ["/**/home"]\n')
    assert policy.moves(Verb.SEND, '/arm/reach')
    assert policy.moves(Verb.PUBLISH, '/base/twist_cmd')
    assert policy.moves(Verb.CALL, '/arm/home')
    assert not policy.moves(Verb.PUBLISH, '/cmd_vel')
    assert read_policy('').moves(Verb.PUBLISH, '/r1/cmd_vel_unstamped')
    assert not read_policy('').moves(Verb.PUBLISH, '/camera')
    assert not read_policy('').moves(Verb.CALL, '/home')


def test_a_role_forbids_the_stop_and_says_where() -> None:
    policy = read_policy('[roles.a]\n[roles.b]\nstop = false\n[identities]\nann = ["a"]\nben = ["a", "b"]\n')
    assert policy.decide_stop('ann').is_allowed
    assert policy.decide_stop('ben').reason == 'policy.toml:3: b: stop = false'
    assert not policy.decide_stop('cy').is_allowed
    assert not read_policy('[everyone]\nstop = false\n[identities]\nann = []').decide_stop('ann').is_allowed


def test_missions_are_for_those_whose_role_says_so_where_it_holds() -> None:
    policy = read_policy(
        '[roles.a]\n[roles.b]\ndomains = [7]\nmissions = true\n[roles.everyone]\nmissions = true\n'
        '[identities]\nann = ["a"]\nben = ["a", "b"]\ncy = ["everyone"]\n'
    )
    assert policy.decide_missions('ann').reason == (
        "policy.toml:8: none of the roles of 'ann' has missions = true"
    )
    assert policy.decide_missions('ben', 7).reason == 'policy.toml:4: b: missions = true'
    assert policy.decide_missions('ben', 7).is_allowed
    assert not policy.decide_missions('ben', 0).is_allowed
    assert policy.decide_missions('cy').is_allowed
    assert policy.decide_missions('dee').reason == "policy.toml: [identities] does not name 'dee'"
    everyone = read_policy('[everyone]\nmissions = true\n[identities]\nann = []')
    assert everyone.decide_missions('ann').reason == 'policy.toml:2: everyone: missions = true'


def test_in_the_first_policy_operators_command_missions_by_way_of_the_console() -> None:
    named = ('robot', 'operator', 'viewer', 'console')
    lines = ''.join(f'{name} = ["{name}"]\n' for name in named)
    policy = read_policy(FIRST_POLICY + lines)
    assert [name for name in named if policy.decide_missions(name).is_allowed] == ['operator', 'console']


def test_the_first_policy_is_one() -> None:
    assert not read_policy(FIRST_POLICY).grants


@pytest.mark.parametrize('end', ['', '\n', '\n# the end\n', '\n\n[roles.last]\ncall = []\n'])
def test_adding_an_identity_keeps_what_people_wrote(end: str) -> None:
    text = f'# mine\n[roles.a]\n[identities]  # who\n"ann" = ["a"]{end}'
    added = add_identity(text, 'ben', ('a',))
    assert tomllib.loads(added)['identities'] == {'ann': ['a'], 'ben': ['a']}
    assert [line for line in added.splitlines() if 'ben' not in line] == text.splitlines()
    assert add_identity(added, 'ben', ()) == added


@given(st.text(alphabet='[]{}="\'#\n,. ab1\\', max_size=40))
def test_any_text_is_a_policy_or_a_mistake_with_a_place(text: str) -> None:
    places = [(1, 1)]
    with suppress(PolicyError):
        try:
            read_policy(text)
        except PolicyError as error:
            places = [(error.line, error.column)]
            raise
    assert min(min(each) for each in places) >= 1


def test_places_are_those_of_keys_and_elements() -> None:
    text = '[a."b c"]\nx.y = ["1", # one\n "2"]\nz = """\n[no]\n"""\n[[q]]\nw = {v = [1]}\n'
    places = find_places(text)
    assert places['a', 'b c'] == Place(1, 1)
    assert places['a', 'b c', 'x', 'y', 1] == Place(3, 2)
    assert places['a', 'b c', 'z'] == Place(4, 1)
    assert ('no',) not in places
