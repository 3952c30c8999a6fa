"""The interface between a client and the parts of its session."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from goalwire.apps.bridge.client_tasks import ClientTasks
from goalwire.apps.bridge.foxglove.frames import ERROR
from goalwire.apps.bridge.hub import Hub
from goalwire.apps.bridge.outbox import Outbox
from goalwire.apps.bridge.permissions import Permissions

Fields = Mapping[str, Any]


class BadFieldError(ValueError):
    """A field of an operation is missing or has a wrong value."""


class Client(ClientTasks):
    """A client, as the parts of its session use it."""

    def __init__(self, hub: Hub, outbox: Outbox, permissions: Permissions) -> None:
        super().__init__(hub, permissions)
        self.outbox = outbox

    def send(self, op: str, **fields: Any) -> None:
        """Send an operation."""
        self.outbox.put([json.dumps({'op': op, **fields}, separators=(',', ':'))])

    def tell(self, text: str, level: int = ERROR) -> None:
        """Send a status message, which Foxglove lists under Problems."""
        self.send('status', level=level, message=text)


def numbers_of(fields: Fields, name: str) -> list[int]:
    """Return a list of ids. Raises BadFieldError."""
    values = fields.get(name)
    if not isinstance(values, list) or not all(type(each) is int for each in values):
        raise BadFieldError(f"'{name}' must be a list of numbers")
    return values


def texts_of(fields: Fields, name: str) -> list[str]:
    """Return a list of names. Raises BadFieldError."""
    values = fields.get(name, [])
    if not isinstance(values, list) or not all(isinstance(each, str) for each in values):
        raise BadFieldError(f"'{name}' must be a list of texts")
    return values


def objects_of(fields: Fields, name: str) -> list[Fields]:
    """Return a list of objects. Raises BadFieldError."""
    values = fields.get(name)
    if not isinstance(values, list) or not all(isinstance(each, dict) for each in values):
        raise BadFieldError(f"'{name}' must be a list of objects")
    return values
