"""Who may open the page: whoever shows the token of this console, or somebody whom its keystore knows.

With an identity (GOALWIRE_SECURITY) each visitor signs in under a name of the policy, by a token or by a
client certificate. Without an identity all visitors show the same token; they need none if only this machine
can reach the page.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from goalwire.errors import SecurityError
from goalwire.records import record
from goalwire.security.sign_in.authorizer import Authorizer, Principal
from goalwire.web_admission import is_same_token
from goalwire.zenoh.io.identities import read_peer_certificate

CERTIFICATE = 'certificate'
"""The name under which a request's state holds the browser's certificate, in the form of `ssl`."""
SIGN_OUT = '/console/sign-out'
"""The path that deletes the cookie with the token."""
PRINCIPAL = 'principal'
"""The name under which a request's state holds the visitor."""


@record
class Visitor:
    """Somebody who may open the page."""

    principal: Principal | None = None
    """The name under which the visitor has signed in, and its rights; None if visitors do not sign in."""
    token: str = ''
    """The token that the visitor has shown; '' with a certificate, and if no token is needed."""


class Entry(Protocol):
    """Decides who may open the page."""

    @property
    def has_names(self) -> bool:
        """True if each visitor signs in under a name."""

    @property
    def is_open(self) -> bool:
        """True if whoever reaches the port may open the page."""

    def admit(self, shown: Iterable[str], certificate: Mapping[str, Any] | None) -> Visitor:
        """Return the visitor who shows these tokens. Raises SecurityError, which says why no token counts."""


class SharedToken:
    """An Entry for all who know one shared token; with the token '' everybody may enter."""

    has_names = False

    def __init__(self, token: str) -> None:
        self._token = token

    @property
    def is_open(self) -> bool:
        """True if there is no token."""
        return not self._token

    def admit(self, shown: Iterable[str], certificate: Mapping[str, Any] | None) -> Visitor:  # noqa: ARG002
        """Compare the tokens with this console's. Raises SecurityError."""
        if self._token and not any(is_same_token(each, self._token) for each in shown):
            raise SecurityError('open the address that the console printed: it has the token')
        return Visitor(token=self._token)


class SignIn:
    """An Entry for people and programs whom a keystore knows."""

    has_names = True
    is_open = False

    def __init__(self, authorizer: Authorizer) -> None:
        self._authorizer = authorizer

    def admit(self, shown: Iterable[str], certificate: Mapping[str, Any] | None) -> Visitor:
        """Find the visitor by the first token that is not empty, or by the certificate if there is no token.

        Raises SecurityError.
        """
        for token in filter(None, shown):
            return Visitor(self._authorizer.find_principal(token), token)
        if not certificate:
            raise SecurityError('')
        found = read_peer_certificate(certificate)
        return Visitor(self._authorizer.admit(found.name, found.begins, found.ends))
