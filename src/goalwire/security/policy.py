"""The rights of identities, in ROS's words: a pure model, without files and without a wire.

An identity has roles; a role grants verbs on names. An act without a grant is forbidden. Names are fully
qualified; in a pattern `*` stands for any signs between two slashes, and `/**` for any number of
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
class Decision:
    """A decision of a policy: yes or no, and why."""

    is_allowed: bool
    reason: str
    """A sentence, with the line of the policy that decides."""


@record
class Policy:
    """The content of a policy.toml."""

    mode: str
    grants: Mapping[str, tuple[Grant, ...]]
    """The grants of each named identity, with those of `everyone`."""
    title: str = 'policy.toml'
    """The name of its file, as answers show it."""
    lines: Mapping[str, int] = {}
    """The line in which each identity is named."""

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
