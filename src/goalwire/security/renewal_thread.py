"""Renews the certificate of a program while it runs, in good time before its end."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from http.client import HTTPException
from threading import Lock, Thread
from time import time
from typing import TYPE_CHECKING

from goalwire.errors import SecurityError
from goalwire.security.environment import Chosen

if TYPE_CHECKING:
    import ssl

_LEAST_WAIT_S, _MOST_WAIT_S = 1.0, 3600.0
"""Bounds, in s, of the wait between two attempts, which is a tenth of the certificate's remaining time."""
_DAY_S = 86_400


def is_possible(chosen: Chosen) -> bool:
    """Return True if the identity's certificate can be renewed, here or by an authority."""
    return any((chosen.folder / name).exists() for name in ('site.pem', 'authority.toml'))


class RenewalThread:
    """Renews the certificate of one identity, on a thread that lives only while there is something to do."""

    def __init__(self, chosen: Chosen, tell: Callable[[str], None]) -> None:
        """`tell` gets a sentence if the certificate cannot be renewed."""
        self._chosen = chosen
        self._tell = tell
        self._next = 0.0
        """When the next renewal is due, in s since the epoch; 0 if that is unknown yet."""
        self._thread: Thread | None = None
        self._connection: ssl.SSLSocket | None = None
        self._is_closed = False
        self._is_told = False
        self._lock = Lock()

    def begin_if_due(self) -> None:
        """Begin to renew if it is time for that; return at once."""
        if time() < self._next or (self._thread is not None and self._thread.is_alive()):
            return
        with self._lock:
            if self._is_closed:
                return
            self._thread = Thread(target=self._run, name='goalwire renewal', daemon=True)
            self._thread.start()

    def close(self) -> None:
        """Break off a running renewal, and wait for the thread."""
        with self._lock:
            self._is_closed = True
            if self._connection is not None:
                self._break_off(self._connection)
        if self._thread is not None:
            self._thread.join()

    @staticmethod
    def _break_off(connection: ssl.SSLSocket) -> None:
        import socket

        with suppress(OSError):  # the connection is closed already
            # SSLSocket's own method would remove the TLS session that another thread still reads from.
            socket.socket.shutdown(connection, socket.SHUT_RDWR)

    def _keep(self, connection: ssl.SSLSocket) -> None:
        with self._lock:
            self._connection = connection
            if self._is_closed:
                self._break_off(connection)

    def _run(self) -> None:
        try:
            from goalwire.security.renewal import renew_if_due

            self._next = renew_if_due(self._chosen, self._keep)
            self._is_told = False
        except (SecurityError, OSError, HTTPException, ImportError) as error:
            self._try_again(error)
        finally:
            with self._lock:
                self._connection = None

    def _try_again(self, error: Exception) -> None:
        from goalwire.security.renewal import end_of

        if self._is_closed:
            return
        try:
            left = max(end_of(self._chosen) - time(), 0.0)
        except (SecurityError, OSError):
            left = 0.0
        self._next = time() + min(max(left / 10, _LEAST_WAIT_S), _MOST_WAIT_S)
        if not self._is_told:
            self._is_told = True
            self._tell(
                f"the certificate of '{self._chosen.name}' ends in {left / _DAY_S:.1f} days and cannot be "
                f'renewed: {error}; further attempts follow, see: goalwire secure check'
            )
