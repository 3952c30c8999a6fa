"""Message classes for the topics of a bag.

A class is the one that is known here, or else one that is made from the definition in the bag.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from goalwire.cdr.codec import decoder
from goalwire.errors import InterfaceError, UnknownInterfaceError
from goalwire.idl import get_interface, register_definitions, type_hash
from goalwire.idl.registry import split_name
from goalwire.rosbag2.definitions import ENCODING
from goalwire.rosbag2.model import Topic

_RULE = '=' * 80
_PARTS = {'srv': ('Request', 'Response'), 'action': ('Goal', 'Result', 'Feedback')}
"""The parts that a .srv or .action file defines."""


def class_of(topic: Topic, topics: Iterable[Topic] = ()) -> type:
    """Return the message class of a topic.

    `topics` are all topics of its bag, since each topic of an action defines only a part of the action.
    Raises InterfaceError if the type is neither known here nor defined in the bag, and if the bag was
    recorded with another definition of the type.
    """
    try:
        cls = get_interface(topic.type_name)
    except InterfaceError:
        if topic.schema.encoding != ENCODING:
            raise
        _define(topic, topics)
        cls = get_interface(topic.type_name)
    if topic.type_hash and type_hash(cls) != topic.type_hash:
        raise InterfaceError(
            f"'{topic.name}' was recorded with another definition of {topic.type_name} than the one here"
        )
    return cls


def decoder_of(topic: Topic, topics: Iterable[Topic] = ()) -> Callable[[bytes], Any]:
    """Return a function that decodes a topic's messages; raises what `class_of` raises."""
    return decoder(class_of(topic, topics))


def _define(topic: Topic, topics: Iterable[Topic]) -> None:
    """Register the definitions of a topic's schema that are unknown here. Those of an action are in the
    schemas of several topics.
    """
    package, kind, name = split_name(topic.type_name)
    texts = _texts_of(topic)
    for each, text in texts.items():
        _register_message(each, text)
    if kind == 'msg':
        return
    for other in topics:
        if other.schema.encoding == ENCODING and other.type_name.startswith(f'{package}/'):
            texts = _texts_of(other) | texts
    whole = name.partition('_')[0]
    text = texts[f'{package}/{name}']
    if '---' not in text.splitlines():  # rosbag2 stores the whole .srv, which has '---'
        parts = [f'{package}/{whole}_{part}' for part in _PARTS[kind]]
        missing = [part for part in parts if part not in texts]
        if missing:
            raise UnknownInterfaceError(
                f'{topic.type_name}: neither this machine nor the bag has {missing[0]}'
            )
        text = '---\n'.join(texts[part] for part in parts)
    register_definitions(package, {f'{kind}/{whole}': text})


def _texts_of(topic: Topic) -> dict[str, str]:
    """Return the definitions in a topic's schema by the names of their types, such as `pkg/Name`."""
    package, _, name = topic.type_name.split('/')
    root, *parts = topic.schema.text.split(f'{_RULE}\nMSG: ')
    texts = {f'{package}/{name}': root}
    for part in parts:
        head, _, text = part.partition('\n')
        package, _, rest = head.strip().partition('/')
        texts[f'{package}/{rest.rpartition("/")[2]}'] = text
    return texts


def _register_message(name: str, text: str) -> None:
    """Register a message type unless it is known; parts of services and actions are registered with their
    service or action.
    """
    package, _, base = name.partition('/')
    if '_' in base:
        return
    try:
        get_interface(f'{package}/msg/{base}')
    except InterfaceError:
        register_definitions(package, {f'msg/{base}': text})
