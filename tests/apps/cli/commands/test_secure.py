"""goalwire secure: a keystore from nothing, carried to another machine, as people type it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command_line import CommandLine, executable
from helpers.isolation import isolated_env
from helpers.markdown import ROOT
from helpers.patience import wait_for
from helpers.processes import Program

from goalwire.security.policy import Verb
from goalwire.security.policy_file import load_policy


@pytest.fixture
def line(tmp_path: Path) -> CommandLine:
    return CommandLine(isolated_env('rmw_zenoh_cpp'), tmp_path)


@pytest.mark.slow
def test_an_identity_is_made_carried_and_revoked(line: CommandLine, tmp_path: Path) -> None:
    line.ok('secure', 'init', 'keys')
    line.ok('secure', 'add', 'robby', '--robot', '-k', 'keys')
    line.ok('secure', 'add', 'alice', '--person', '--role', 'operator', '-k', 'keys')
    assert line.ok('secure', 'export', 'robby', '-k', 'keys').startswith('robby.identity holds the key')
    taken = line.ok('secure', 'import', 'robby.identity', 'there')
    assert taken == f'robby is in there; next: export GOALWIRE_SECURITY={tmp_path}/there:robby\n'
    assert line.ok('secure', 'check', GOALWIRE_SECURITY='there:robby') == 'there: nothing is wrong\n'
    line.ok('secure', 'revoke', 'alice', '-k', 'keys')
    shown = [json.loads(each) for each in line.ok('secure', 'list', '--json', '-k', 'keys').splitlines()]
    assert [(each['name'], 'revoked' in each) for each in shown] == [('robby', False), ('alice', True)]


@pytest.mark.slow
def test_settings_for_rmw_zenoh_name_the_identity(line: CommandLine) -> None:
    line.ok('secure', 'init', 'keys')
    line.ok('secure', 'add', 'site', '--router', '-k', 'keys')
    router = json.loads(line.ok('secure', 'config', 'router', 'site', '-k', 'keys'))
    assert router['access_control']['default_permission'] == 'deny'
    assert router['transport']['link']['tls']['listen_certificate'].endswith('/keys/identities/site.pem')
    session = json.loads(line.ok('secure', 'config', 'session', 'site', '-k', 'keys', '--router-host', 'r'))
    assert (session['mode'], session['connect']['endpoints']) == ('client', ['tls/r:7447'])
    assert line.fails('router', '--secure', code=2).startswith('ros2: --secure needs an identity')


@pytest.mark.slow
def test_a_router_keeps_the_policy_and_takes_its_changes(line: CommandLine, tmp_path: Path) -> None:
    line.ok('secure', 'init', 'keys')
    for name, kind in (('site', '--router'), ('robby', '--robot'), ('ann', '--person')):
        line.ok('secure', 'add', name, kind, '-k', 'keys')
    policy = tmp_path / 'keys' / 'policy.toml'
    port = line.env['GOALWIRE_ROUTER_PORT']
    client = {'ZENOH_CONFIG_OVERRIDE': f'mode="client";connect/endpoints=["tls/localhost:{port}"]'}

    def env(name: str) -> dict[str, str]:
        return {**line.env, **client, 'GOALWIRE_SECURITY': f'{tmp_path}/keys:{name}'}

    call = ('service', 'call', '--timeout', '2', '/add_two_ints', 'example_interfaces/srv/AddTwoInts')
    secure = {**line.env, 'GOALWIRE_SECURITY': f'{tmp_path}/keys:site'}
    with Program(executable(), 'router', '--secure', env=secure) as router:
        router.expect('listens on')
        with Program(ROOT / 'examples' / 'add_two_ints_server.py', env=env('robby')) as server:
            server.expect('Ready')
            ann = CommandLine(env('ann'), tmp_path)
            assert '/add_two_ints' in ann.ok('service', 'list')
            assert ann(*call, '{a: 2, b: 3}').code != 0
            policy.write_text(policy.read_text().replace('"ann" = ["viewer"]', '"ann" = ["operator"]'))
            router.expect('the router starts anew')
            router.expect('listens on')
            wait_for(lambda: 'sum=5' in ann(*call, '{a: 2, b: 3}').out)


@pytest.mark.slow
def test_a_router_misses_no_change_of_the_policy_while_it_starts(line: CommandLine, tmp_path: Path) -> None:
    """A change between the reading of the policy and the first look at its file was lost for good."""
    line.ok('secure', 'init', 'keys')
    line.ok('secure', 'add', 'site', '--router', '-k', 'keys')
    policy = tmp_path / 'keys' / 'policy.toml'
    secure = {**line.env, 'GOALWIRE_SECURITY': f'{tmp_path}/keys:site'}
    with Program(executable(), 'router', '--secure', env=secure) as router:
        for _ in range(6):
            router.expect('listens on')
            policy.write_text(policy.read_text() + '# changed\n')
            router.expect('the router starts anew')


@pytest.mark.slow
@pytest.mark.parametrize('stays', [False, True], ids=['for a moment', 'for good'])
def test_a_router_that_starts_anew_waits_for_a_port_that_was_taken(
    line: CommandLine, tmp_path: Path, *, stays: bool
) -> None:
    """A command that began at that moment offered the rendezvous, and the router ended for good."""
    line.ok('secure', 'init', 'keys')
    line.ok('secure', 'add', 'site', '--router', '-k', 'keys')
    policy = tmp_path / 'keys' / 'policy.toml'
    port = line.env['GOALWIRE_ROUTER_PORT']
    secure = {**line.env, 'GOALWIRE_SECURITY': f'{tmp_path}/keys:site'}
    with Program(executable(), 'router', '--secure', env=secure) as router:
        router.expect('listens on')
        with Program(TAKES_PORT, port) as other:
            other.expect('ready')
            found = ''
            while 'is held by' not in found:  # the router may be quicker
                policy.write_text(policy.read_text() + '# changed\n')
                router.expect('the router starts anew')
                found = router.expect('listens on|is held by .* the router tries again for 10 s').group()
            if stays:
                assert router.wait() == 10
        if not stays:
            router.expect('listens on')


TAKES_PORT = """
import socket, sys
print('ready', flush=True)
while True:
    with socket.socket(socket.AF_INET6) as server:
        try:
            server.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
            server.bind(('::', int(sys.argv[1])))
        except OSError:
            continue
        server.listen()
        sys.stdin.readline()
        break
"""
"""Listens on a port as soon as it is free."""


@pytest.mark.slow
def test_a_learnt_policy_allows_what_was_seen_and_no_more(line: CommandLine, tmp_path: Path) -> None:
    with (
        Program(ROOT / 'examples' / 'fibonacci_action_server.py', env=line.env) as counter,
        Program(ROOT / 'examples' / 'add_two_ints_server.py', env=line.env) as adder,
    ):
        counter.expect('Ready')
        adder.expect('Ready')
        line.ok('secure', 'learn', '--for', '1', '-o', 'policy.toml')
    policy = load_policy(tmp_path / 'policy.toml')
    assert policy.mode == 'audit'
    for verb, name, is_allowed in (
        (Verb.SERVE, '/add_two_ints', True),
        (Verb.SERVE, '/fibonacci', True),
        (Verb.SERVE, '/add_two_ints_server/get_parameters', True),
        (Verb.PUBLISH, '/rosout', True),
        (Verb.RUN, '/add_two_ints_server', True),
        (Verb.CALL, '/add_two_ints', False),
        (Verb.SERVE, '/other', False),
        (Verb.PUBLISH, '/chatter', False),
    ):
        assert policy.decide('robot', verb, name).is_allowed is is_allowed, (verb, name)


@pytest.mark.slow
def test_explain_says_yes_or_no_and_which_line(line: CommandLine, tmp_path: Path) -> None:
    policy = '[roles.op]\ncall = ["/reset"]\n[identities]\nann = ["op"]\n'
    (tmp_path / 'policy.toml').write_text(policy)
    yes = line.ok('secure', 'explain', 'ann', 'call', '/reset')
    assert yes == 'yes: policy.toml:2: op: call /reset\n'
    no = line('secure', 'explain', 'ann', 'call', '/other')
    assert (no.code, no.out) == (7, "no: policy.toml:4: none of the roles of 'ann' may call '/other'\n")
    no = line('secure', 'explain', 'ann', 'missions')
    assert (no.code, no.out) == (7, "no: policy.toml:4: none of the roles of 'ann' has missions = true\n")
    (tmp_path / 'policy.toml').write_text(policy.replace('call', 'cal'))
    assert line.fails('secure', 'explain', 'ann', 'call', '/x', code=1) == (
        "ros2: policy.toml:2:1: 'cal' is not a verb; did you mean 'call' or 'cancel'?"
    )
