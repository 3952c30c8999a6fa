"""Definitions that are short and make huge or endless messages are refused at the field that is too much."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.names import fresh_package

from goalwire.cdr import codec
from goalwire.errors import InterfaceSyntaxError
from goalwire.idl import get_message, get_service, register_definitions, type_hash
from goalwire.idl.extent import MAX_DEPTH, MAX_FIELDS


def make(definitions: dict[str, str]) -> Any:
    """Return the class of the first message."""
    package = fresh_package()
    register_definitions(package, definitions)
    return get_message(f'{package}/{next(iter(definitions))}')


def nested(levels: int, per_level: str = 'A{0} inner') -> dict[str, str]:
    inner = {f'msg/A{level}': per_level.format(level + 1) for level in range(levels - 1)}
    return inner | {f'msg/A{levels - 1}': 'int32 x'}


def test_a_message_may_have_as_many_levels_as_the_documentation_says() -> None:
    cls = make(nested(MAX_DEPTH))
    message = cls()
    assert repr(message).count('inner=') == MAX_DEPTH - 1
    assert codec.decode(codec.encode(message), cls) == message
    assert type_hash(cls)


@pytest.mark.parametrize('levels', [MAX_DEPTH + 1, 100, 300, 3000])
def test_more_levels_are_refused_with_the_file_and_the_line(levels: int) -> None:
    with pytest.raises(InterfaceSyntaxError, match=r'A\d+\.msg:1:1: field inner: .*levels of messages'):
        make(nested(levels))


def test_the_levels_count_whichever_type_is_made_first() -> None:
    package = fresh_package()
    register_definitions(package, nested(MAX_DEPTH + 1))
    for level in reversed(range(1, MAX_DEPTH + 1)):
        get_message(f'{package}/msg/A{level}')
    with pytest.raises(
        InterfaceSyntaxError, match=rf'A0 has {MAX_DEPTH + 1} levels .*; {MAX_DEPTH} are allowed'
    ):
        get_message(f'{package}/msg/A0')


def test_a_service_may_use_the_deepest_message() -> None:
    package = fresh_package()
    register_definitions(package, nested(MAX_DEPTH - 1) | {'srv/Ask': 'A0 what\n---\nA0[] all'})
    ask: Any = get_service(f'{package}/srv/Ask')
    event = ask.Event(request=[ask.Request()])
    assert codec.decode(codec.encode(event), ask.Event) == event


def test_fields_that_double_at_each_level_are_refused() -> None:
    with pytest.raises(InterfaceSyntaxError, match=r':2:1: field b: .* fields, those of nested'):
        make(nested(40, 'A{0} a\nA{0} b'))


def test_a_message_of_many_fields_works_and_of_more_is_refused() -> None:
    cls = make({'msg/Wide': '\n'.join(f'bool a{n}' for n in range(1000))})
    assert codec.decode(codec.encode(cls(a7=True)), cls).a7
    text = '\n'.join(f'bool a{n}' for n in range(MAX_FIELDS + 5))
    with pytest.raises(InterfaceSyntaxError, match=rf':{MAX_FIELDS}:1: field a{MAX_FIELDS - 1}: '):
        make({'msg/Wider': text})


@pytest.mark.parametrize(
    'text',
    ['string[4294967295] x', 'uint8[4294967295] x', 'bool[4194304] x', 'Inner[3000] x', 'Empty[4194305] x'],
)
def test_arrays_that_hold_too_much_are_refused(text: str) -> None:
    with pytest.raises(InterfaceSyntaxError, match=r'Huge\.msg:1:1: field x: .* values in each new message'):
        make({'msg/Huge': text, 'msg/Inner': 'string[3000] names', 'msg/Empty': ''})


def test_arrays_of_numbers_may_hold_images() -> None:
    cls = make({'msg/Image': 'uint8[24883200] data'})  # 3840 x 2160 pixels of three bytes
    assert cls().data.nbytes == 24883200
