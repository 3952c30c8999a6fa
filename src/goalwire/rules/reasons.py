"""Why a server leaves a request unanswered: the text that it sends, and the error that the client raises.

The text travels if both ends are goalwire: in an error reply on Zenoh, in a refusal on DDS.
ROS 2's own clients ignore it.
"""

from __future__ import annotations

from goalwire.errors import (
    CallError,
    DeadlineError,
    PermissionDeniedError,
    RefusedError,
    ServerFailedError,
    ServerLostError,
    peer_text,
)

CLOSING = 'the server is closing'
STOPPED = 'its callback was stopped'
TIMEOUT = 'Timeout'
"""Zenoh's own word, when it gives a query up: after ten minutes, as under rmw_zenoh."""
_REFUSED = 'refused: '
_REJECTED = 'rejected: '
_DENIED = 'denied: '


def refused(problem: str) -> str:
    """The server has too much to do."""
    return peer_text(_REFUSED + problem)


def rejected(error: Exception) -> str:
    """Return the reason for a request that breaks the rules."""
    return peer_text(f'{_REJECTED}{error}')


def denied(rule: str) -> str:
    """The server's policy does not allow it; `rule` says which line, to whom and what."""
    return peer_text(_DENIED + rule)


def failed(error: BaseException) -> str:
    """The server's callback ended in `error`: its type and text, no traceback."""
    if not isinstance(error, Exception):
        return STOPPED
    return peer_text(f'its callback failed: {described(error)}')


def described(error: BaseException) -> str:
    """Return an error in one line: its type and its text."""
    kind, text = type(error).__name__, str(error)
    return f'{kind}: {text}' if text else kind


def meaning(reason: str) -> type[CallError]:
    """Return the error of a client that gets no answer, for `reason` ('': none was given)."""
    if not reason or reason == CLOSING:
        return ServerLostError
    if reason == TIMEOUT:
        return DeadlineError
    if reason.startswith(_DENIED):
        return PermissionDeniedError
    return RefusedError if reason.startswith((_REFUSED, _REJECTED)) else ServerFailedError
