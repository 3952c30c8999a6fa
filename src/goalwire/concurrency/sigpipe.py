"""Keeps writes to a peer that has gone from raising the signal SIGPIPE.

The system answers such a write with SIGPIPE. Python ignores that signal, but some programs restore its
default action, which kills them. So every write to a socket has these flags: it then fails with EPIPE only.
"""

from __future__ import annotations

import _socket  # not `socket`, which must not be imported while Ctrl-C ends the program
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import socket

NO_SIGPIPE: int = getattr(_socket, 'MSG_NOSIGNAL', 0)
"""The flag for each write. 0 if the system has no SIGPIPE, or has an option of the socket instead."""

_SO_NOSIGPIPE = 0x1022
"""The number of the socket's option on macOS; Python has no name for it."""


def refuse_sigpipe(sock: socket.socket) -> None:
    """Have writes to a socket raise no SIGPIPE, on systems where that is an option of the socket."""
    if sys.platform == 'darwin':
        sock.setsockopt(_socket.SOL_SOCKET, _SO_NOSIGPIPE, 1)
