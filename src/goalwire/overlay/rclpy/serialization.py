"""rclpy.serialization: converts messages to bytes and back."""

from __future__ import annotations

from typing import TypeVar

from goalwire.entities.type_support import message_support
from goalwire.transport.contract import Payload
from rclpy._reexports import reexport

MessageT = TypeVar('MessageT')


def serialize_message(message: object) -> bytes:
    """Return the message as CDR (little endian, 4 bytes of header).

    Raises AttributeError for anything but a message, EncodeError (a TypeError or ValueError, too) if a
    field's value does not fit.
    """
    cls: type = type(message)
    return message_support(cls).encode(message)


def deserialize_message(serialized_message: Payload, message_type: type[MessageT]) -> MessageT:
    """Return the message that the bytes hold.

    Raises TypeError for anything but bytes, AttributeError for anything but a message class, and DecodeError
    (a ValueError, too) for bytes that are not a message of that class.
    """
    if not isinstance(serialized_message, bytes | bytearray | memoryview):
        raise TypeError(
            f'a serialized message is bytes, bytearray or memoryview, '
            f'not {type(serialized_message).__name__}: {serialized_message!r:.80}'
        )
    cls: type = message_type
    message: MessageT = message_support(cls).decode(serialized_message)
    return message


reexport(__name__)
