"""Signs people and programs in at a console or a bridge, and asks the policy about them.

Such a server has an identity of its own, and the robots know only the server's identity. So the server asks
the same policy about each of those who sign in: they may do only what the policy allows both to them and to
the server. What they do is in the audit log of the server's identity.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor

from goalwire.errors import SecurityError
from goalwire.logging import get_logger
from goalwire.records import record
from goalwire.security import audit
from goalwire.security.audited_moves import MOVES, Entry, Streams, write_entry
from goalwire.security.environment import Chosen
from goalwire.security.file_changes import look_at
from goalwire.security.needs import Permission
from goalwire.security.policy import STOP, Decision, Policy, Verb
from goalwire.security.policy_file import load_policy
from goalwire.security.revocation import load_revocations, why_refused
from goalwire.security.sign_in.tokens import Token, find_token, load_tokens, tokens_path

LOGGER = 'goalwire.security'
PUBLISH = Verb.PUBLISH.value
MOST_TEXT = 500
"""How many characters of an audit entry say what was sent."""


@record
class Principal:
    """Somebody who has signed in: a name in the policy, and the time in which the token or certificate is
    valid.
    """

    name: str
    issued: float
    """The time of issue, in s since the epoch."""
    ends: float
    sha256: str = ''
    """The hash of the token; '' for a certificate."""


class Authorizer:
    """The keystore of a server's identity, as the server uses it. Changes to the keystore's files count at
    once.
    """

    def __init__(self, chosen: Chosen, domain: int = 0) -> None:
        """`domain` is the domain in which the server acts. Raises SecurityError if a file cannot be used."""
        self.identity = chosen
        self._domain = domain
        self._paths = (chosen.folder / 'policy.toml', chosen.folder / 'revoked.toml')
        self._files = (*self._paths, tokens_path(chosen.folder))
        self._seen = look_at(self._files)
        self._policy = load_policy(self._paths[0])
        self._revoked = load_revocations(self._paths[1])
        self._tokens: tuple[Token, ...] = load_tokens(chosen.folder)
        self._streams = Streams(self._put)
        # One thread writes the audit log, so that no act waits for the disk, and least of all a stop.
        self._disk = ThreadPoolExecutor(1, 'goalwire-audit')
        self._is_audit_lost = False

    # ---- who is there

    def find_principal(self, token: str) -> Principal:
        """Return who signs in with a token. Raises SecurityError, which says why the token is refused."""
        self._look()
        found = find_token(self._tokens, token)
        if found is None:
            raise SecurityError('the token is not known here')
        principal = Principal(found.name, found.issued.timestamp(), found.ends.timestamp(), found.sha256)
        return self._require(principal)

    def admit(self, name: str, issued: float, ends: float) -> Principal:
        """Return who signs in with a certificate, which TLS has verified. Raises SecurityError."""
        self._look()
        return self._require(Principal(name, issued, ends))

    def _require(self, principal: Principal) -> Principal:
        problem = self.problem_of(principal)
        if problem:
            raise SecurityError(problem)
        return principal

    def problem_of(self, principal: Principal) -> str:
        """Return why somebody must sign in again; '' if the token or certificate still counts."""
        self._look()
        if principal.sha256 and all(each.sha256 != principal.sha256 for each in self._tokens):
            return f"the token of '{principal.name}' was deleted"
        what = 'token' if principal.sha256 else 'certificate'
        return why_refused(
            what, principal.name, principal.issued, principal.ends, self._policy, self._revoked
        )

    # ---- what each may do

    def decide(self, principal: Principal, permission: Permission) -> Decision:
        """Decide if both the principal and the server may do something. A refusal names the line of the
        policy.
        """
        problem = self.problem_of(principal)
        if problem:
            return Decision(False, problem)
        own = self._decide(self.identity.name, permission)
        return self._decide(principal.name, permission) if own.is_allowed else own

    def _decide(self, who: str, permission: Permission) -> Decision:
        decisions = [
            self._policy.decide(who, verb, permission.name, self._domain) for verb in permission.verbs
        ]
        return next((each for each in decisions if each.is_allowed), decisions[0])

    def refuses(self, principal: Principal, decision: Decision) -> bool:
        """Return whether a decision stops an act; with mode = "audit" it is only logged."""
        return not decision.is_allowed and (self._policy.is_enforced or bool(self.problem_of(principal)))

    def decide_stop(self, principal: Principal) -> Decision:
        """Decide if somebody may use the emergency stop. The server's own rights are not checked: a robot
        that refuses the server says so itself. To refuse a stop here could only be wrong.
        """
        problem = self.problem_of(principal)
        return Decision(False, problem) if problem else self._policy.decide_stop(principal.name)

    def decide_missions(self, principal: Principal) -> Decision:
        """Decide if both the principal and the server may command missions. A refusal names the policy's
        line.
        """
        problem = self.problem_of(principal)
        if problem:
            return Decision(False, problem)
        own = self._policy.decide_missions(self.identity.name, self._domain)
        return self._policy.decide_missions(principal.name, self._domain) if own.is_allowed else own

    @property
    def policy(self) -> Policy:
        """The policy as its file is now."""
        self._look()
        return self._policy

    def moves(self, permission: Permission) -> bool:
        """Return whether an act moves a robot, as the policy says."""
        return any(self._policy.moves(verb, permission.name, self._domain) for verb in permission.verbs)

    # ---- what they do

    def note(self, principal: Principal, permission: Permission, decision: Decision, what: str = '') -> None:
        """Put into the audit log that somebody sends `what`, in one line, or was refused."""
        act = permission.verbs[0].value
        outcome = self._outcome(principal, decision, MOVES if self.moves(permission) else 'done')
        if act == PUBLISH and decision.is_allowed:
            self._streams.note(outcome, principal.name, act, permission.name, decision.reason)
            return
        self._put_act(outcome, principal, act, permission.name, decision, what)

    def note_mission(
        self, principal: Principal, act: str, mission: str, decision: Decision, what: str = ''
    ) -> None:
        """Write a command to a mission, allowed or refused, into the audit log: it may move the robot."""
        self._put_act(self._outcome(principal, decision, MOVES), principal, act, mission, decision, what)

    def _outcome(self, principal: Principal, decision: Decision, if_allowed: str) -> str:
        if self.refuses(principal, decision):
            return 'was refused'
        return if_allowed if decision.is_allowed else 'would be refused'

    def _put_act(
        self, outcome: str, principal: Principal, act: str, name: str, decision: Decision, what: str
    ) -> None:
        more = {'what': what[:MOST_TEXT]} if what else {}
        via = self.identity.name
        self._put(write_entry(outcome, principal.name, act, name, decision.reason, via=via, **more))

    def note_done(self, principal: Principal, act: str, name: str, text: str) -> None:
        """Put into the audit log what somebody has done: signed in, stopped or released a robot."""
        self._put(write_entry('done', principal.name, act, name, text, via=self.identity.name))

    def note_stop(
        self, principal: Principal, names: Iterable[str], decision: Decision, act: str = STOP
    ) -> None:
        """Write an emergency stop, or another act that only stops a robot, into the audit log."""
        outcome = 'stops' if decision.is_allowed else 'was refused'
        for name in names:
            self._put_act(outcome, principal, act, name, decision, '')

    def _put(self, entry: Entry) -> None:
        self._disk.submit(self._write, entry)

    def _write(self, entry: Entry) -> None:
        path = audit.log_path(self.identity.folder, self.identity.name)
        try:
            audit.append(path, entry)
        except OSError as error:
            if not self._is_audit_lost:
                self._is_audit_lost = True
                get_logger(LOGGER).error(f"the audit log '{path}' cannot be written: {error}")

    # ---- what changes

    def _look(self) -> None:
        """Read the files again if they have changed. If that fails, keep the old content, and log it."""
        seen = look_at(self._files)
        if seen == self._seen:
            return
        self._seen = seen
        try:
            self._policy, self._revoked, self._tokens = (
                load_policy(self._paths[0]),
                load_revocations(self._paths[1]),
                load_tokens(self.identity.folder),
            )
        except SecurityError as error:
            get_logger(LOGGER).error(f'the keystore has changed, and the old one holds on: {error}')
        self._streams.look()

    def close(self) -> None:
        """Write the last entries of the audit log."""
        self._streams.close()
        self._disk.shutdown()
