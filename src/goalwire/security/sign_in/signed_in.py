"""Somebody who has signed in at a console or a bridge, and what they may do."""

from __future__ import annotations

from collections.abc import Sequence

from goalwire.errors import NotAllowedError
from goalwire.security.needs import Permission
from goalwire.security.policy import STOP, Decision
from goalwire.security.sign_in.authorizer import Authorizer, Principal


class SignedIn:
    """The rights of one principal. What is done and what is refused stands in the audit log."""

    def __init__(self, authorizer: Authorizer, principal: Principal) -> None:
        self._authorizer = authorizer
        self._principal = principal
        self._policy = authorizer.policy

    @property
    def name(self) -> str:
        """The principal's name in the policy."""
        return self._principal.name

    def problem(self) -> str:
        """Return why this principal must sign in again; '' if there is no reason.

        If the principal's rights change, the connections opened before are closed, as sessions' links are.
        """
        problem = self._authorizer.problem_of(self._principal)
        policy = self._authorizer.policy
        if problem or policy is self._policy:
            return problem
        if policy.rights_of(self.name) != self._policy.rights_of(self.name):
            return f"what '{self.name}' may do has changed"
        self._policy = policy
        return ''

    def why_not(self, permission: Permission) -> str:
        """Return why an act is refused, with the line of the policy that decides; '' if it is allowed."""
        decision = self._authorizer.decide(self._principal, permission)
        return decision.reason if self._authorizer.refuses(self._principal, decision) else ''

    def check_to_look(self, permission: Permission) -> None:
        """Raise NotAllowedError if the principal may not look at something."""
        reason = self.why_not(permission)
        if reason:
            self.note(permission, Decision(False, reason))
            raise NotAllowedError(reason)

    def check_to_send(self, permission: Permission, what: str = '') -> None:
        """Raise NotAllowedError if the principal may not send something; the audit log shows it as `what`."""
        decision = self._authorizer.decide(self._principal, permission)
        self.note(permission, decision, what)
        if self._authorizer.refuses(self._principal, decision):
            raise NotAllowedError(f'{decision.reason}: nothing was sent')

    def why_not_stop(self) -> str:
        """Return why the emergency stop is refused; '' if it is allowed."""
        decision = self._authorizer.decide_stop(self._principal)
        return '' if decision.is_allowed else decision.reason

    def check_to_stop(self, names: Sequence[str], act: str = STOP) -> None:
        """Raise NotAllowedError if the emergency stops of these names may not be used.

        `act` names the act in the audit log, if it is not the emergency stop.

        Everybody who has signed in may use the stops, unless a role says `stop = false`: a gap in a policy
        must not cost anybody the stop.
        """
        decision = self._authorizer.decide_stop(self._principal)
        self._authorizer.note_stop(self._principal, names, decision, act)
        if not decision.is_allowed:
            raise NotAllowedError(f'{decision.reason}: nothing was stopped')

    def why_not_missions(self) -> str:
        """Return why the policy refuses commands to missions; '' if it allows them."""
        decision = self._authorizer.decide_missions(self._principal)
        return decision.reason if self._authorizer.refuses(self._principal, decision) else ''

    def check_to_command(self, mission: str, act: str, what: str = '') -> None:
        """Raise NotAllowedError if the policy refuses a command; `act` and `what` are for the audit log."""
        decision = self._authorizer.decide_missions(self._principal)
        self.note_mission(mission, act, decision, what)
        if self._authorizer.refuses(self._principal, decision):
            raise NotAllowedError(f'{decision.reason}: nothing was sent')

    def note_mission(self, mission: str, act: str, decision: Decision, what: str = '') -> None:
        """Write a command to a mission into the audit log, also if it was refused."""
        self._authorizer.note_mission(self._principal, act, mission, decision, what)

    def note(self, permission: Permission, decision: Decision, what: str = '') -> None:
        """Put into the audit log what is sent, or was refused."""
        self._authorizer.note(self._principal, permission, decision, what)

    def note_done(self, act: str, name: str, text: str) -> None:
        """Put into the audit log what was done, if it is not among the acts of a policy."""
        self._authorizer.note_done(self._principal, act, name, text)
