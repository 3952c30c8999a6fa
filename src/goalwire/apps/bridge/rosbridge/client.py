"""The interface between a client and the operations: its requests and their answers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from builtin_interfaces.msg import Time

from goalwire.apps.bridge.client_tasks import ClientTasks
from goalwire.apps.bridge.hub import Hub
from goalwire.apps.bridge.outbox import Outbox
from goalwire.apps.bridge.permissions import Permissions
from goalwire.apps.bridge.rosbridge.encoding import COMPRESSIONS, cbor, frames, json_text
from goalwire.apps.bridge.rosbridge.values import from_values

Operation = Mapping[str, Any]
LEVELS = ('none', 'error', 'warning', 'info')
"""The levels of status messages; each level includes the levels before it."""


class BadOperationError(ValueError):
    """A field of an operation is missing or has an invalid value."""


class Client(ClientTasks):
    """A client, as the operations use it."""

    def __init__(self, hub: Hub, outbox: Outbox, permissions: Permissions) -> None:
        super().__init__(hub, permissions)
        self.outbox = outbox
        self.level = 'error'

    def send(self, message: Mapping[str, Any], request: Operation | None = None) -> None:
        """Send an answer, in the form that the request asks for."""
        asked = request or {}
        compression = asked.get('compression', 'none')
        if compression == 'cbor':
            self.outbox.put([cbor(message)])
        else:
            size = asked.get('fragment_size')
            self.outbox.put(
                frames(json_text(message), size if type(size) is int and size > 0 else None, compression)
            )

    def tell(self, level: str, text: str, request: Operation | None = None) -> None:
        """Send a status message, if the client wants messages of that level."""
        if LEVELS.index(level) <= LEVELS.index(self.level):
            about = {'id': request['id']} if request and 'id' in request else {}
            self.send({'op': 'status', **about, 'level': level, 'msg': text})

    def now(self) -> Any:
        """Return the time of the bridge's clock as a message."""
        seconds, nanoseconds = self.hub.node.clock.now().seconds_nanoseconds()
        return Time(sec=seconds, nanosec=nanoseconds)

    def message(self, cls: Any, values: object, *, has_auto_header: bool = False) -> Any:
        """Return a message made from a client's fields. Raises FieldValueError."""
        return from_values(cls, values, self.now, has_auto_header=has_auto_header)


def text_of(operation: Operation, field: str) -> str:
    """Return a field that must be a text. Raises BadOperationError."""
    value = operation.get(field)
    if not isinstance(value, str) or not value:
        raise BadOperationError(f"{operation['op']}: the field '{field}' must be a text")
    return value


def number_of(operation: Operation, field: str) -> float:
    """Return a field that is a number, 0 or more; 0 if it is left out. Raises BadOperationError."""
    value = operation.get(field) or 0
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 2**31:
        raise BadOperationError(f"{operation['op']}: the field '{field}' must be a number, 0 or more")
    return value


def compression_of(operation: Operation) -> str:
    """Return the compression of messages. Raises BadOperationError."""
    value = operation.get('compression') or 'none'
    if value not in COMPRESSIONS:
        raise BadOperationError(f"{operation['op']}: 'compression' is one of {', '.join(COMPRESSIONS)}")
    return str(value)


def with_id(message: dict[str, Any], request: Operation) -> dict[str, Any]:
    """Return an answer with the id of its request, if that has one."""
    return message | {'id': request['id']} if request.get('id') is not None else message
