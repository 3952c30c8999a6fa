"""The guard of one link: who is at its other end, and what the policy lets that one do."""

from __future__ import annotations

from typing import Protocol

from goalwire.reports import RejectCounters
from goalwire.zenoh.io.identities import PeerCertificate
from goalwire.zenoh.protocol.guard import Act

ROUTER = 'router'
"""The kind of certificates whose links are not checked here: a router has rules of its own."""


class Judge(Protocol):
    """Knows the policy."""

    @property
    def refused(self) -> RejectCounters:
        """Counts what was refused."""

    def refusal(self, who: str, act: Act, key: str, session: str) -> str:
        """Return why an identity may not do something; '' if it may."""


class LinkGuard:
    """The guard of one link."""

    def __init__(self, judge: Judge, certificate: PeerCertificate) -> None:
        self._judge = judge
        self.certificate = certificate
        """The newest certificate that the other side has shown."""
        self.who = certificate.name
        self.forwards = certificate.kind == ROUTER
        self.shown = 0
        """How many renewals of this session's own certificate the other side has been told of."""

    def refusal(self, act: Act, key: str, session: str) -> str:
        """Return why the other side may not do something; '' if it may."""
        if self.forwards:
            return ''
        return self._judge.refusal(self.who, act, key, session)

    def count(self, act: Act) -> None:
        """Count an act that was refused."""
        self._judge.refused.count(f'refused {act.value}', self.who)
