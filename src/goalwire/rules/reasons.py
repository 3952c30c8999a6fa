"""The reasons why a server gives no answer: the text that it sends, and the error that the client raises.

The text is sent if both ends are goalwire: in an error reply on Zenoh, in a refusal on DDS. ROS 2's own
clients ignore it.
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
"""Zenoh's own text when it gives up a query: after ten minutes, as under rmw_zenoh."""
_REFUSED = 'refused: '
_REJECTED = 'rejected: '
_DENIED = 'denied: '


def refused(problem: str) -> str:
    """Return the reason for a request to a server that has too much to do."""
    return peer_text(_REFUSED + problem)


def rejected(error: Exception) -> str:
    """Return the reason for a request that breaks the rules."""
    return peer_text(f'{_REJECTED}{error}')


def denied(rule: str) -> str:
    """Return the reason for a request that the server's policy denies; `rule` is the line of the policy."""
    return peer_text(_DENIED + rule)


def failed(error: BaseException) -> str:
    """Return the reason for a request whose callback raised `error`: its type and text, no traceback."""
    if not isinstance(error, Exception):
        return STOPPED
    return peer_text(f'its callback failed: {described(error)}')


def described(error: BaseException) -> str:
    """Return the type and the text of an error in one line."""
    kind, text = type(error).__name__, str(error)
    return f'{kind}: {text}' if text else kind


def meaning(reason: str) -> type[CallError]:
    """Return the error that a client raises for a `reason` ('' if the server gave none)."""
    if not reason or reason == CLOSING:
        return ServerLostError
    if reason == TIMEOUT:
        return DeadlineError
    if reason.startswith(_DENIED):
        return PermissionDeniedError
    return RefusedError if reason.startswith((_REFUSED, _REJECTED)) else ServerFailedError
