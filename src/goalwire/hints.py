"""Adds remedies to errors that Python itself raises in programs of ROS 2, since these errors name no remedy.

`traceback_text` asks for the remedy when an error is shown. goalwire's own errors say themselves what to do.
"""

from __future__ import annotations

import re
import sys
from typing import TYPE_CHECKING, Any

from goalwire.errors import did_you_mean
from goalwire.patterns import Pattern

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType


def hint_for(error: BaseException) -> str:
    """Return in one sentence what to write instead of the wrong code; '' if no remedy is known for
    the error.
    """
    if not isinstance(error, TypeError | AttributeError) or error.__traceback__ is None:
        return ''
    text = str(error)
    for pattern, explain in _HINTS:
        if (found := pattern.search(text)) and (hint := explain(found, _innermost(error))):
            return hint
    return _unset_attribute(error) if isinstance(error, AttributeError) else ''


def _innermost(error: BaseException) -> FrameType:
    trace = error.__traceback__
    assert trace is not None
    while trace.tb_next is not None:
        trace = trace.tb_next
    return trace.tb_frame


def _positional_field(found: re.Match[str], frame: FrameType) -> str:
    cls = _find_variable(frame, found[1])
    fields = list(_fields_of(cls))
    return f'give each field its name: write {found[1]}({fields[0]}=…)' if fields else ''


def _unknown_field(found: re.Match[str], _frame: FrameType) -> str:
    from difflib import get_close_matches

    made = getattr(sys.modules.get('goalwire.idl.classes'), 'find_made_classes', None)
    for fields in map(_fields_of, [] if made is None else made(found[1])):
        if not fields:
            return f'{found[1]} has no fields'
        near = get_close_matches(found[2].lower(), fields, n=1, cutoff=0.5)
        inside = _field_that_has(found[2], fields, made)
        advice = f'write .{inside}.{found[2]}' if inside else did_you_mean(near)
        return f'{found[1]} has the fields {", ".join(fields)}; {advice}'.rstrip('; ')
    return ''


def _field_that_has(name: str, fields: dict[str, str], made: Any) -> str:
    """Return the field whose own message has a field `name`, such as `feedback` of a feedback message."""
    for field, type_name in fields.items():
        if any(name in _fields_of(cls) for cls in made(type_name.rpartition('/')[2])):
            return field
    return ''


def _unfinished_future(_found: re.Match[str], frame: FrameType) -> str:
    for name, value in {**frame.f_globals, **frame.f_locals}.items():
        if getattr(value, 'completion_state', None) == 0 and hasattr(value, 'add_done_callback'):
            return (
                f"the answer that '{name}' stands for has not come yet, so {name}.result() is None: write "
                f"rclpy.spin_until_future_complete(node, {name}) before, or in an 'async def' await {name}"
            )
    return ''


def _unset_attribute(error: BaseException) -> str:
    """Return the hint for an unknown attribute of a node: if no known name is similar, it was probably never
    set.
    """
    from difflib import get_close_matches

    owner, name = getattr(error, 'obj', None), getattr(error, 'name', '')
    cls = type(owner)
    if not hasattr(cls, 'create_publisher') or get_close_matches(name, dir(owner), n=1, cutoff=0.8):
        return ''  # Python's own text suggests the name that was meant
    return (
        f"this {cls.__name__} has no '{name}' yet: write 'self.{name} = …' in {cls.__name__}.__init__(), "
        f"or a method 'def {name}(self, …)'"
    )


def _say(sentence: str) -> Callable[[re.Match[str], FrameType], str]:
    return lambda found, _: found.expand(sentence)


def _find_variable(frame: FrameType, name: str) -> object:
    return frame.f_locals.get(name, frame.f_globals.get(name))


def _fields_of(cls: Any) -> dict[str, str]:
    fields = getattr(cls, 'get_fields_and_field_types', None)
    return fields() if fields is not None and isinstance(cls, type) else {}


_HINTS: tuple[tuple[Pattern, Callable[[re.Match[str], FrameType], str]], ...] = (
    (Pattern(r'^(\w+)\.__init__\(\) takes 1 positional argument but'), _positional_field),
    (
        Pattern(r'^RcutilsLogger\.(\w+)\(\) takes 2 positional arguments but'),
        _say(r"a log call takes one text: write \1(f'… {value}')"),
    ),
    (
        Pattern(r"missing 1 required positional argument: 'qos_profile'$"),
        _say('give the number of messages that are kept as the last argument, such as 10'),
    ),
    (
        Pattern(r"^Node\.__init__\(\) missing 1 required positional argument: 'node_name'$"),
        _say("give the node a name: write super().__init__('talker')"),
    ),
    (
        Pattern(r"^unsupported operand type\(s\) for [+-]=?: 'Time' and '(?:int|float)'$"),
        _say('write Duration(seconds=…), from rclpy.duration, in place of the number'),
    ),
    (Pattern(r"^'NoneType' object has no attribute '\w+'$"), _unfinished_future),
    # Python 3.13 adds 'and no __dict__ …' as a field is set
    (Pattern(r"^'([A-Z]\w*)' object has no attribute '(\w+)'(?: and no __dict__ .*)?$"), _unknown_field),
)
