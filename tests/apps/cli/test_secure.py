"""goalwire secure: a keystore from nothing, carried to another machine, as people type it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command_line import CommandLine
from helpers.isolation import NETWORK, isolated_env


@pytest.fixture
def line(tmp_path: Path) -> CommandLine:
    return CommandLine(isolated_env(NETWORK), tmp_path)


@pytest.mark.slow
def test_an_identity_is_made_carried_and_revoked(line: CommandLine, tmp_path: Path) -> None:
    line.ok('secure', 'init', 'keys')
    line.ok('secure', 'add', 'robby', '--robot', '-k', 'keys')
    line.ok('secure', 'add', 'alice', '--person', '--role', 'operator', '-k', 'keys')
    assert line.ok('secure', 'export', 'robby', '-k', 'keys').startswith('robby.identity holds the key')
    taken = line.ok('secure', 'import', 'robby.identity', 'there')
    assert taken == 'robby is in there; next: export GOALWIRE_SECURITY=there:robby\n'
    assert line.ok('secure', 'check', GOALWIRE_SECURITY='there:robby') == 'there: nothing is wrong\n'
    line.ok('secure', 'revoke', 'alice', '-k', 'keys')
    shown = [json.loads(each) for each in line.ok('secure', 'list', '--json', '-k', 'keys').splitlines()]
    assert [(each['name'], 'revoked' in each) for each in shown] == [('robby', False), ('alice', True)]


@pytest.mark.slow
def test_explain_says_yes_or_no_and_which_line(line: CommandLine, tmp_path: Path) -> None:
    policy = '[roles.op]\ncall = ["/reset"]\n[identities]\nann = ["op"]\n'
    (tmp_path / 'policy.toml').write_text(policy)
    yes = line.ok('secure', 'explain', 'ann', 'call', '/reset')
    assert yes == 'yes: policy.toml:2: op: call /reset\n'
    no = line('secure', 'explain', 'ann', 'call', '/other')
    assert (no.code, no.out) == (7, "no: policy.toml:4: none of the roles of 'ann' may call '/other'\n")
    (tmp_path / 'policy.toml').write_text(policy.replace('call', 'cal'))
    assert line.fails('secure', 'explain', 'ann', 'call', '/x', code=1) == (
        "ros2: policy.toml:2:1: 'cal' is not a verb; did you mean 'call' or 'cancel'?"
    )
