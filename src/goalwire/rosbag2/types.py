"""Message classes for the topics of a bag.

Those that are known here, else those that the bag itself defines.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from goalwire.cdr.codec import decoder
from goalwire.errors import InterfaceError, UnknownInterfaceError
from goalwire.idl import get_interface, register_definitions, type_hash
from goalwire.rosbag2.definitions import ENCODING
from goalwire.rosbag2.model import Topic

_RULE = '=' * 80


def class_of(topic: Topic) -> type:
    """Return the message class of a topic.

    Raises InterfaceError if its type is neither known here nor defined in the bag, and where it was
    another type under the same name that was recorded.
    """
    try:
        cls = get_interface(topic.type_name)
    except InterfaceError:
        if topic.schema.encoding != ENCODING:
            raise
        _define(topic)
        cls = get_interface(topic.type_name)
    if topic.type_hash and type_hash(cls) != topic.type_hash:
        raise InterfaceError(
            f"'{topic.name}' was recorded with another definition of {topic.type_name} than the one here"
        )
    return cls


def decoder_of(topic: Topic) -> Callable[[bytes], Any]:
    """Return a function that decodes a topic's messages; raises as `class_of`."""
    return decoder(class_of(topic))


def _define(topic: Topic) -> None:
    """Register the unknown definitions in a topic's schema."""
    parts = topic.schema.text.split(f'{_RULE}\nMSG: ')
    _register(topic.type_name, parts[0])
    for part in parts[1:]:
        name, _, text = part.partition('\n')
        package, _, kind = name.strip().partition('/')
        _register(f'{package}/msg/{kind.rpartition("/")[2]}', text)


def _register(type_name: str, text: str) -> None:
    package, kind, name = type_name.split('/')
    if kind != 'msg' or '_' in name:
        raise UnknownInterfaceError(f'{type_name}: a part of a service or action cannot be taken from a bag')
    try:
        get_interface(type_name)
    except InterfaceError:
        register_definitions(package, {f'msg/{name}': text})
