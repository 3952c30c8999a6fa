"""The guard of one link: the identity of the peer, and the checks of what it may do."""

from __future__ import annotations

from typing import Protocol

from goalwire.zenoh.io.identities import PeerCertificate
from goalwire.zenoh.protocol.guard import Act, Witness

ROUTER = 'router'
"""The kind of a router's certificate. Links to routers are not checked here: a router has its own rules."""


class Judge(Protocol):
    """Decides by the policy what an identity may do."""

    def refusal(self, who: str, act: Act, key: str, session: str) -> str:
        """Return why an identity may not do something; '' if it may."""

    def count(self, who: str, act: Act, key: str) -> None:
        """Count an act that was refused."""

    def witness(self, who: str, act: Act, key: str) -> Witness | None:
        """Return a function to call at each allowed act of an identity; None if no call is needed."""


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

    def count(self, act: Act, key: str) -> None:
        """Count an act that was refused."""
        self._judge.count(self.who, act, key)

    def witness(self, act: Act, key: str) -> Witness | None:
        """Return a function to call at each allowed act of the peer, even a router; None if not needed."""
        return self._judge.witness(self.who, act, key)
