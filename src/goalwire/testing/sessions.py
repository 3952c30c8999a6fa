"""Which sessions are open: what a test leaves behind is found by them."""

from __future__ import annotations

from goalwire.transport import registry
from goalwire.transport.contract import Session, SessionOptions, Transport


class _Noted(Transport):
    """A transport whose sessions are noted."""

    def __init__(self, inner: Transport, sessions: dict[Session, None]) -> None:
        self.identifier = inner.identifier
        self._inner = inner
        self._sessions = sessions

    def open(self, options: SessionOptions) -> Session:
        """Connect, and forget the session when it is closed."""
        session = self._inner.open(options)
        close, sessions = session.close, self._sessions
        sessions[session] = None

        def close_and_forget() -> None:
            close()
            sessions.pop(session, None)

        session.close = close_and_forget  # type: ignore[method-assign]
        return session


class Sessions:
    """The sessions that this process has opened since, and not closed."""

    def __init__(self) -> None:
        self._open: dict[Session, None] = {}
        self._unwrap = registry.wrap(lambda inner: _Noted(inner, self._open))

    def open(self) -> list[Session]:
        """Return them, oldest first."""
        return list(self._open)

    def stop(self) -> None:
        """Note no more. Idempotent."""
        self._unwrap()
