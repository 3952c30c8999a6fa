"""The rights of identities, in ROS's words: a pure model, without files and without a wire.

An identity has roles; a role grants verbs on names. An act without a grant is forbidden. Names are fully
qualified; in a pattern `*` stands for any characters between two slashes, and `/**` for any number of
such parts: `/arm/**` are /arm and all that is below it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from enum import Enum
from functools import lru_cache

from goalwire.records import record


class Verb(Enum):
    """An act of an identity; the values are the words of policy.toml."""

    RUN = 'run'
    """Create a node of that name."""
    PUBLISH = 'publish'
    SUBSCRIBE = 'subscribe'
    CALL = 'call'
    """Call a service, except services for parameters and services of actions."""
    SERVE = 'serve'
    """Offer a service or an action, also a node's services for its parameters."""
    SEND = 'send'
    """Send goals of an action, and get their feedback, status and results."""
    CANCEL = 'cancel'
    """The verb for cancelling goals of an action."""
    WATCH = 'watch'
    """Get feedback, status and results of an action's goals."""
    READ = 'read'
    """Read and list the parameters of a node of that name."""
    SET = 'set'
    """Set parameters of a node of that name."""
    INTROSPECT = 'introspect'
    """See a node, with its topics, services and actions, in the graph."""


MODES = ('enforce', 'audit')

STOP = 'stop'
"""The word for the emergency stop of a console. Everybody may use the stop, unless the policy forbids it to
them.
"""
MISSIONS = 'missions'
"""The key of a role that allows people to answer, resume and undo missions in a console."""


@record
class Grant:
    """One line of a role: a verb, a pattern of names, and the domains in which it holds (empty: all)."""

    verb: Verb
    pattern: str
    role: str = ''
    line: int = 0
    domains: tuple[int, ...] = ()

    def covers(self, verb: Verb, name: str, domain: int) -> bool:
        """Return True if the grant allows this act."""
        return (
            verb is self.verb and (not self.domains or domain in self.domains) and matches(self.pattern, name)
        )


@record
class MissionGrant:
    """A role with `missions = true`: its line, and the domains in which the role holds (empty: all)."""

    role: str
    line: int
    domains: tuple[int, ...] = ()


@record
class Decision:
    """A decision of a policy: yes or no, and why."""

    is_allowed: bool
    reason: str
    """A sentence, with the line of the policy that decides."""


def _grants(verb: Verb, *patterns: str) -> tuple[Grant, ...]:
    return tuple(Grant(verb, pattern, 'moving') for pattern in patterns)


MOVING = (
    *_grants(Verb.SEND, '/**'),
    *_grants(
        Verb.PUBLISH,
        '/**/cmd_vel*',
        '/**/*_cmd',
        '/**/command*',
        '/**/joint_trajectory',
        '/**/twist',
    ),
)
"""The acts that move a robot if a policy does not list them: goals of all actions, and commands on topics."""


@record
class Policy:
    """The content of a policy.toml."""

    mode: str
    grants: Mapping[str, tuple[Grant, ...]]
    """The grants of each named identity, with those of `everyone`."""
    title: str = 'policy.toml'
    """The name of the policy's file, as answers show it."""
    lines: Mapping[str, int] = {}
    """The line in which each identity is named."""
    moving: tuple[Grant, ...] = MOVING
    """The acts that move a robot: the audit log has each of them, even if it is allowed."""
    may_not_stop: Mapping[str, tuple[str, int]] = {}
    """For each identity the role, with its line, that forbids it the emergency stop of a console."""
    missions: Mapping[str, tuple[MissionGrant, ...]] = {}
    """The roles with `missions = true`, by the identity that has them."""

    @property
    def is_enforced(self) -> bool:
        """True if forbidden acts are refused; False if they are only logged."""
        return self.mode == 'enforce'

    def knows(self, who: str) -> bool:
        """Whether the policy names an identity. Identities without a name have no rights."""
        return who in self.grants

    def decide(self, who: str, verb: Verb, name: str, domain: int = 0) -> Decision:
        """Decide if an identity may do something, and name the line that decides it."""
        grants = self.grants.get(who)
        if grants is None:
            return Decision(False, f"{self.title}: [identities] does not name '{who}'")
        for grant in grants:
            if grant.covers(verb, name, domain):
                return Decision(
                    True, f'{self.title}:{grant.line}: {grant.role}: {verb.value} {grant.pattern}'
                )
        where = f' in domain {domain}' if domain else ''
        return Decision(
            False,
            f"{self.title}:{self.lines.get(who, 0)}: none of the roles of '{who}' may "
            f"{verb.value} '{name}'{where}",
        )

    def decide_stop(self, who: str) -> Decision:
        """Decide if an identity may use the emergency stop of a console: yes, unless a role forbids it."""
        if who not in self.grants:
            return self.decide(who, Verb.CALL, '/')
        if who in self.may_not_stop:
            role, line = self.may_not_stop[who]
            return Decision(False, f'{self.title}:{line}: {role}: stop = false')
        line = self.lines.get(who, 0)
        return Decision(True, f"{self.title}:{line}: no role of '{who}' has stop = false")

    def decide_missions(self, who: str, domain: int = 0) -> Decision:
        """Decide if an identity may command missions in a console: no, unless a role allows it."""
        if who not in self.grants:
            return self.decide(who, Verb.CALL, '/')
        for each in self.missions.get(who, ()):
            if not each.domains or domain in each.domains:
                return Decision(True, f'{self.title}:{each.line}: {each.role}: missions = true')
        where = f' in domain {domain}' if domain else ''
        line = self.lines.get(who, 0)
        return Decision(
            False, f"{self.title}:{line}: none of the roles of '{who}' has missions = true{where}"
        )

    def rights_of(self, who: str) -> object:
        """Return a value that changes if the rights of an identity change, but not if only the policy's lines
        move.
        """
        grants = {(each.verb, each.pattern, each.domains) for each in self.grants.get(who, ())}
        missions = {each.domains for each in self.missions.get(who, ())}
        return self.mode, grants, who in self.may_not_stop, missions

    def moves(self, verb: Verb, name: str, domain: int = 0) -> bool:
        """Return whether an act moves a robot, as the policy or its default says."""
        return any(each.covers(verb, name, domain) for each in self.moving)


@lru_cache(maxsize=1024)
def _expression(pattern: str) -> re.Pattern[str]:
    """Return the regular expression of a pattern of names."""
    parts = []
    for chunk in pattern.split('/')[1:]:
        if chunk == '**':
            parts.append('(?:/[^/]+)*')
        elif chunk == '*':
            parts.append('/[^/]+')
        else:
            parts.append('/' + '[^/]*'.join(map(re.escape, chunk.split('*'))))
    return re.compile(''.join(parts))


def matches(pattern: str, name: str) -> bool:
    """Whether a name matches a pattern."""
    return _expression(pattern).fullmatch(name) is not None
