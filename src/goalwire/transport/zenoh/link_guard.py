"""The guard of one link: the identity of the peer, and the checks of what it may do."""

from __future__ import annotations

from typing import Protocol

from goalwire.reports import RejectCounters
from goalwire.zenoh.io.identities import PeerCertificate
from goalwire.zenoh.protocol.guard import Act

ROUTER = 'router'
"""The kind of a router's certificate. Links to routers are not checked here: a router has its own rules."""


class Judge(Protocol):
    """Decides by the policy."""

    @property
    def refused(self) -> RejectCounters:
        """The counters of refused acts."""

    def refusal(self, who: str, act: Act, key: str, session: str) -> str:
        """Return why an identity may not do something; '' if it may."""


class LinkGuard:
    """The guard of one link."""

    def __init__(self, judge: Judge, certificate: PeerCertificate) -> None:
        self._judge = judge
        self.certificate = certificate
        """The newest certificate that the peer has shown."""
        self.who = certificate.name
        self.forwards = certificate.kind == ROUTER
        self.shown = 0
        """The number of the latest renewal of this session's certificate that was shown to the peer."""

    def refusal(self, act: Act, key: str, session: str) -> str:
        """Return why the peer may not do something; '' if it may."""
        if self.forwards:
            return ''
        return self._judge.refusal(self.who, act, key, session)

    def count(self, act: Act) -> None:
        """Count an act that was refused."""
        self._judge.refused.count(f'refused {act.value}', self.who)
