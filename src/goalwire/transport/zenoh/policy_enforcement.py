"""Checks what comes over links against the policy, by the identities of the links' certificates.

The policy, the list of revoked names and this session's own certificate are read again when their files
change. A link is closed and made again if the rights of its identity have changed. It is closed for good if
its certificate has expired or was revoked.
"""

from __future__ import annotations

from collections import deque
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.errors import SecurityError
from goalwire.fault_reports import LOGGER, RejectCounters
from goalwire.rules import reasons
from goalwire.security import audit
from goalwire.security.audited_moves import MOVES, Streams, write_entry
from goalwire.security.environment import Chosen
from goalwire.security.file_changes import look_at
from goalwire.security.policy import Policy, Verb
from goalwire.security.policy_file import load_policy
from goalwire.security.refusal_counts import RefusalCounts
from goalwire.security.renewal_thread import RenewalThread, is_possible
from goalwire.security.revocation import load_revocations, why_refused
from goalwire.transport.zenoh import policy_questions
from goalwire.transport.zenoh.certificate_succession import Succession
from goalwire.transport.zenoh.link_guard import LinkGuard
from goalwire.transport.zenoh.policy_questions import Question
from goalwire.zenoh.io.identities import PeerCertificate
from goalwire.zenoh.protocol.guard import Act, Witness
from goalwire.zenoh.protocol.primitives import GENERIC

if TYPE_CHECKING:
    from goalwire.zenoh.io.native_session import NativeSession

LOOK_S = 1.0
"""Seconds between two checks of files and of certificates' expiry; a check takes three calls of stat.

inotify would need no checks, but it reports no changes in network folders.
"""
GOAL_ID = slice(4, 20)
"""The bytes of a serialized SendGoal request that hold the goal's id, right after the CDR header."""
MOST_TOLD = 4096
"""How many different refusals are logged, since a peer could invent names without limit."""


class PolicyEnforcement:
    """The identity, the policy and the revoked names that one session has read from the keystore."""

    def __init__(self, chosen: Chosen) -> None:
        """Raises SecurityError if the policy or the list of revoked names cannot be used."""
        self.refused = RejectCounters()
        self.identity = chosen
        self._policy_path = chosen.folder / 'policy.toml'
        self._revoked_path = chosen.folder / 'revoked.toml'
        self._files = (self._policy_path, self._revoked_path, chosen.identity_path)
        self._seen = look_at(self._files)
        self._policy = load_policy(self._policy_path)
        self._revoked = load_revocations(self._revoked_path)
        self._audit_path = audit.log_path(chosen.folder, chosen.name)
        self._is_audit_lost = False
        self._unwritten: deque[dict[str, str]] = deque()
        self._streams = Streams(self._unwritten.append)
        self.refusals = RefusalCounts(chosen.name)
        self._told: set[tuple[str, Act, str]] = set()
        self._lock = Lock()
        self._succession = Succession(chosen)
        self._renewal = RenewalThread(chosen, _log_error) if is_possible(chosen) else None

    # ---- the identity of a link

    def identify(self, certificate: PeerCertificate) -> LinkGuard:
        """Return the guard of a link. Raises SecurityError if the identity is revoked or unknown."""
        problem = self._why_refused(certificate)
        if problem:
            raise SecurityError(problem)
        return LinkGuard(self, certificate)

    def _why_refused(self, certificate: PeerCertificate) -> str:
        name = certificate.name
        if not name:
            return 'the certificate of the other side names nobody'
        return why_refused(
            'certificate', name, certificate.begins, certificate.ends, self._policy, self._revoked
        )

    # ---- what an identity may do

    def refusal(self, who: str, act: Act, key: str, session: str) -> str:
        """Return why an identity may not do something, as a text for that identity; '' if it may."""
        policy = self._policy
        if policy_questions.is_of_links(act, key, session):
            return ''
        if act in policy_questions.LEARNING:
            asked = policy_questions.any_of(act, key, session) or ()
            is_allowed = any(not _why_not(policy, who, each) for each in asked)
            return '' if is_allowed or not policy.is_enforced else 'hidden'
        every = policy_questions.all_of(act, key, session)
        if every is None:
            reason = f"'{who}' may not use the key '{key}', or not in the name of this session"
        else:
            reason = next(filter(None, (_why_not(policy, who, each) for each in every)), '')
        if not reason:
            return ''
        # A refused RECEIVE is not logged: the peer gets no messages, but has done nothing wrong.
        if act is not Act.RECEIVE:
            self._tell(policy, who, act, key, reason)
        if not policy.is_enforced:
            return ''
        return reasons.explain_denial(self._in_short(policy, reason))

    def _in_short(self, policy: Policy, reason: str) -> str:
        """Return a reason without the path of the policy."""
        return reason.replace(policy.title, self._policy_path.name)

    def _tell(self, policy: Policy, who: str, act: Act, key: str, reason: str) -> None:
        """Log the first refusal of each identity, act and key, and queue it for the audit log."""
        with self._lock:
            if (who, act, key) in self._told or len(self._told) >= MOST_TOLD:
                return
            self._told.add((who, act, key))
        from goalwire.logging import get_logger

        what = 'was refused' if policy.is_enforced else 'would be refused'
        get_logger(LOGGER).warning(f"'{who}': a {act.value} {what}: {reason}")
        # Written later: the session's section must not wait for a disk
        self._unwritten.append(write_entry(what, who, act.value, key, reason))
        self.refusals.note(who, policy_questions.describe(act, key), self._in_short(policy, reason))

    def count(self, who: str, act: Act, key: str) -> None:
        """Count an act that was refused."""
        self.refused.count(f'refused {act.value}', who)
        self.refusals.count(who, policy_questions.describe(act, key))

    # ---- acts that move the robot

    def witness(self, who: str, act: Act, key: str) -> Witness | None:
        """Return a function that audits an identity's acts on the key; None if they move nothing."""
        policy = self._policy
        for question in policy_questions.all_of(act, key, '') or ():
            verb = question.verbs[0]
            if len(question.verbs) == 1 and policy.moves(verb, question.name, question.domain):
                reason = policy.decide(who, verb, question.name, question.domain).reason
                return partial(self._tell_of_move, who, verb, question.name, reason)
        return None

    def _tell_of_move(
        self, who: str, verb: Verb, name: str, reason: str, payload: bytes | memoryview | None
    ) -> None:
        """Queue an audit entry about an act that moves the robot; for a sent goal the entry has its id."""
        if verb is Verb.PUBLISH:
            self._streams.note(MOVES, who, verb.value, name, reason)
            return
        more = {}
        if verb is Verb.SEND and payload is not None:
            more['goal'] = bytes(payload[GOAL_ID]).hex()
        self._unwritten.append(write_entry(MOVES, who, verb.value, name, reason, **more))

    def write_audit(self) -> None:
        """Write the queued entries into the audit log. A failure is logged once."""
        self._streams.look()
        entries = [self._unwritten.popleft() for _ in range(len(self._unwritten))]
        if not entries:
            return
        try:
            audit.append(self._audit_path, *entries)
        except OSError as error:
            if not self._is_audit_lost:
                self._is_audit_lost = True
                from goalwire.logging import get_logger

                get_logger(LOGGER).error(f"the audit log '{self._audit_path}' cannot be written: {error}")

    def close(self) -> None:
        """Write the queued entries, and stop the renewal of the certificate."""
        if self._renewal is not None:
            self._renewal.close()
        self._streams.close()
        self.refusals.close()
        self.write_audit()

    # ---- what changes

    def watch(self, session: NativeSession) -> None:
        """Begin to check the files and the certificates of the session's links, every LOOK_S seconds."""

        self._succession.listen(session)

        def look() -> None:
            session.call_later(LOOK_S, look)
            self.write_audit()
            self.refusals.tell()
            if self._renewal is not None:
                self._renewal.begin_if_due()
            before = self._policy
            seen = look_at(self._files)
            if seen != self._seen:
                self._succession.renewals += seen[-1] != self._seen[-1]
                if seen[:-1] != self._seen[:-1]:
                    self._reload()
                self._seen = seen
            self._succession.show_to_all(session)
            if self._policy.moving != before.moving:
                session.protocol.section.run(session.protocol.routes.forget)  # the witnesses are found anew
            self._close_links(session, before)

        session.call_later(LOOK_S, look)

    def _reload(self) -> None:
        """Read the policy and the revoked names again. If that fails, keep the old ones and log the error."""
        from goalwire.logging import get_logger

        try:
            policy, revoked = load_policy(self._policy_path), load_revocations(self._revoked_path)
        except SecurityError as error:
            get_logger(LOGGER).error(f'the keystore has changed, and the old one holds on: {error}')
            return
        with self._lock:
            self._told.clear()
        self._policy, self._revoked = policy, revoked
        get_logger(LOGGER).info(f'{self._policy_path} and {self._revoked_path.name} are read anew')

    def _close_links(self, session: NativeSession, before: Policy) -> None:
        """Close links whose peer is refused now, or has other rights than before."""
        after = self._policy
        for link in session.protocol.links:
            guard = link.guard
            if not isinstance(guard, LinkGuard):
                continue
            why = self._why_refused(guard.certificate)
            if not why and after is not before and after.rights_of(guard.who) != before.rights_of(guard.who):
                why = f"what '{guard.who}' may do has changed"
            if why:
                session.close_link(link, why, GENERIC)


def _log_error(text: str) -> None:
    from goalwire.logging import get_logger

    get_logger(LOGGER).error(text)


def _why_not(policy: Policy, who: str, question: Question) -> str:
    """Return why none of a question's verbs is allowed; '' if one is."""
    reason = ''
    for verb in question.verbs:
        decision = policy.decide(who, verb, question.name, question.domain)
        if decision.is_allowed:
            return ''
        reason = reason or decision.reason
    return reason
