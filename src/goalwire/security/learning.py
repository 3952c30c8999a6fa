"""Writes the policy that a running system needs, from its observed acts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from goalwire.patterns import Pattern
from goalwire.security.policy import Verb

_NO_WORD = Pattern(r'[^A-Za-z0-9_]+')

HEAD = """\
# What was seen, and no more: goalwire secure learn wrote this. Read it before you use it. What a program
# does only now and then may be missing: try it with mode = "audit", and look for what would be refused.

mode = "audit"
"""


class Need(NamedTuple):
    """An act of a node that needs a permission."""

    identity: str
    node: str
    verb: Verb
    name: str


def write_policy(needs: Iterable[Need]) -> str:
    """Return a policy with a role for each node, and the identities that have them."""
    roles: dict[str, dict[Verb, set[str]]] = {}
    members: dict[str, set[str]] = {}
    for identity, node, verb, name in needs:
        role = _NO_WORD.sub('_', node).strip('_')
        members.setdefault(identity, set()).add(role)
        granted = roles.setdefault(role, {Verb.RUN: {node}})
        granted.setdefault(verb, set()).add(name)
    lines = [HEAD]
    for role, granted in sorted(roles.items()):
        # A role that may send an action's goals may watch them, too.
        granted[Verb.WATCH] = granted.get(Verb.WATCH, set()) - granted.get(Verb.SEND, set())
        lines.append(f'[roles.{role}]')
        lines += [f'{verb.value} = {_list(granted[verb])}' for verb in Verb if granted.get(verb)]
        lines.append('')
    lines.append('[identities]')
    lines += [f'"{identity}" = {_list(having)}' for identity, having in sorted(members.items())]
    return '\n'.join(lines) + '\n'


def _list(names: set[str]) -> str:
    return '[' + ', '.join(f'"{name}"' for name in sorted(names)) + ']'
