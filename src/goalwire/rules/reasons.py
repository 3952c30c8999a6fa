"""The reasons why a server does not answer a request: their texts, and the errors that clients raise.

If server and client are goalwire's, the text is sent: on Zenoh in an error reply, on DDS in a refusal. ROS
2's own clients ignore it.
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
"""Zenoh's own text for a query that it has given up, after ten minutes, as under rmw_zenoh."""
_REFUSED = 'refused: '
_REJECTED = 'rejected: '
_DENIED = 'denied: '


def explain_refusal(problem: str) -> str:
    """Return the reason for refusing a request because the server is overloaded."""
    return peer_text(_REFUSED + problem)


def explain_rejection(error: Exception) -> str:
    """Return the reason for rejecting a request that cannot be decoded."""
    return peer_text(f'{_REJECTED}{error}')


def explain_denial(rule: str) -> str:
    """Return the reason for a request that the server's policy denies, by the policy's line `rule`."""
    return peer_text(_DENIED + rule)


def explain_failure(error: BaseException) -> str:
    """Return the reason if a service callback raised `error`: its type and text, without a traceback."""
    if not isinstance(error, Exception):
        return STOPPED
    return peer_text(f'its callback failed: {describe_error(error)}')


def describe_error(error: BaseException) -> str:
    """Return the type and the text of an error in one line."""
    kind, text = type(error).__name__, str(error)
    return f'{kind}: {text}' if text else kind


def meaning(reason: str) -> type[CallError]:
    """Return the class of the error that a client raises for a `reason` ('' if the server gave none)."""
    if not reason or reason == CLOSING:
        return ServerLostError
    if reason == TIMEOUT:
        return DeadlineError
    if reason.startswith(_DENIED):
        return PermissionDeniedError
    return RefusedError if reason.startswith((_REFUSED, _REJECTED)) else ServerFailedError
