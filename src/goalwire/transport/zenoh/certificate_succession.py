"""Keeps links open after a certificate was renewed: each side shows the other its new certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.errors import SecurityError
from goalwire.fault_reports import LOGGER
from goalwire.security.environment import Chosen
from goalwire.transport.zenoh.link_guard import LinkGuard
from goalwire.transport.zenoh.policy_questions import CERTIFICATE
from goalwire.zenoh.io.identities import PeerCertificate
from goalwire.zenoh.protocol.primitives import show_id
from goalwire.zenoh.protocol.publication import Publication

if TYPE_CHECKING:
    from goalwire.zenoh.io.native_session import NativeSession
    from goalwire.zenoh.protocol.bodies import Sample


class Succession:
    """Shows this session's renewed certificate to its peers, and takes theirs."""

    def __init__(self, chosen: Chosen) -> None:
        self._chosen = chosen
        self.renewals = 0
        """The number of renewals of this session's certificate."""

    def listen(self, session: NativeSession) -> None:
        """Begin to take certificates that peers show to this session."""
        session.protocol.declare_subscriber(
            CERTIFICATE + session.id, lambda sample: self._take(session, sample), takes_own=False
        )

    def show_to_all(self, session: NativeSession) -> None:
        """Show the newest certificate to the peers that have not seen it yet."""
        for link in session.protocol.links:
            guard = link.guard
            # eclipse-zenoh's router does not take new certificates: links to it are closed and made again.
            if not isinstance(guard, LinkGuard) or guard.forwards or guard.shown == self.renewals:
                continue
            guard.shown = self.renewals
            try:
                self._show(session, show_id(link.zid))
            except (SecurityError, ImportError) as error:
                from goalwire.logging import get_logger

                get_logger(LOGGER).error(f'the renewed certificate cannot be shown: {error}')

    def _show(self, session: NativeSession, receiver: str) -> None:
        from goalwire.security import certificate_succession
        from goalwire.security.keystore import Keystore

        pair = Keystore(self._chosen.folder).identity(self._chosen.name)
        publication = Publication(session.protocol, CERTIFICATE + receiver)
        publication.put(certificate_succession.show(pair, session.id, receiver))
        publication.close()

    def _take(self, session: NativeSession, sample: Sample) -> None:
        """Take a certificate that a peer shows. A wrong one is counted and ignored."""
        if sample.payload is None:
            return
        try:
            self._take_certificate(session, bytes(sample.payload))
        except (SecurityError, ImportError) as error:
            session.refuse('renewed certificate', error)

    def _take_certificate(self, session: NativeSession, message: bytes) -> None:
        from goalwire.security import certificate_succession, certificates
        from goalwire.security.keystore import Keystore

        sender, found = certificate_succession.read_shown(
            message, session.id, Keystore(self._chosen.folder).trust()
        )
        shown = PeerCertificate(
            certificates.common_name(found),
            certificates.kind_of(found),
            found.not_valid_before_utc.timestamp(),
            found.not_valid_after_utc.timestamp(),
        )
        for link in session.protocol.links:
            guard = link.guard
            if not isinstance(guard, LinkGuard) or show_id(link.zid) != sender:
                continue
            if (shown.name, shown.kind) != (guard.who, guard.certificate.kind):
                raise SecurityError(f"'{guard.who}' shows a certificate of '{shown.name}'")
            if shown.ends > guard.certificate.ends:
                guard.certificate = shown
