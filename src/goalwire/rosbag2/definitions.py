"""Makes the text that defines a type and all types that it contains, in MCAP's encoding `ros2msg`.

The root's text comes first; each other type follows a line of 80 `=` and its name. Events of services and
parts of actions have no file of their own: their text is made from the fields, so that every reader can
decode them. For such a type rosbag2 stores the whole .srv, which readers of messages do not understand.
"""

from __future__ import annotations

from goalwire.cdr.type_hash import find_referenced, type_hash
from goalwire.errors import InterfaceError
from goalwire.idl.model import Definition, MessageDefinition
from goalwire.idl.registry import definition_text
from goalwire.idl.rosidl_compat import definition_by_name
from goalwire.rosbag2.model import Schema

ENCODING = 'ros2msg'
_RULE = '=' * 80


def schema_of(type_name: str) -> tuple[Schema, str]:
    """Return the schema and the hash of a message type.

    For an unknown type they are an empty schema and ''.
    """
    try:
        root = definition_by_name(type_name)
        parts = [_text_of(root)]
        for part in find_referenced(root):
            package, _, name = part.full_name.split('/')
            parts.append(f'{_RULE}\nMSG: {package}/{name}\n{_text_of(part)}')
        return Schema(ENCODING, '\n'.join(parts)), type_hash(type_name)
    except InterfaceError:
        return Schema(), ''


def _text_of(definition: Definition) -> str:
    if definition.kind == 'msg':
        try:
            return definition_text(definition.full_name)
        except InterfaceError:  # a class of an installed ROS 2 that has no .msg file
            pass
    assert isinstance(definition, MessageDefinition)
    lines = (f'{field.type.text} {field.name}\n' for field in definition.fields)
    return ''.join(line.replace('/srv/', '/').replace('/action/', '/') for line in lines)
