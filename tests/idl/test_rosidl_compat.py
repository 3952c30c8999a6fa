"""Classes by name and names by class."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.names import fresh_package

import goalwire.idl
from goalwire.cdr import codec
from goalwire.errors import EncodeTypeError, UnknownInterfaceError
from goalwire.idl import (
    get_action,
    get_interface,
    get_message,
    get_service,
    register_definitions,
    type_hash,
    type_name,
)
from goalwire.idl.classes import find_class, own_definition
from goalwire.idl.grammar import parse_service
from goalwire.idl.model import Field, FieldType, MessageDefinition, ServiceDefinition, Shape
from goalwire.idl.rosidl_compat import definition_by_name, definition_of


def test_names_lead_to_classes_and_back() -> None:
    for name, get in (
        ('std_msgs/msg/String', get_message),
        ('std_srvs/srv/SetBool', get_service),
        ('example_interfaces/action/Fibonacci', get_action),
        ('example_interfaces/action/Fibonacci_SendGoal_Request', get_interface),
        ('example_interfaces/action/Fibonacci_GetResult', get_interface),
    ):
        assert type_name(get(name)) == name


def test_the_class_is_the_one_that_import_gives() -> None:
    from std_msgs.msg import String

    assert get_message('std_msgs/msg/String') is String


def test_a_name_of_another_kind_is_refused() -> None:
    with pytest.raises(UnknownInterfaceError, match='std_srvs/srv/SetBool is of kind srv, not msg'):
        get_message('std_srvs/srv/SetBool')


@pytest.mark.parametrize('thing', [int, str, Exception])
def test_other_classes_have_no_name(thing: type) -> None:
    with pytest.raises(UnknownInterfaceError, match='is not a message, service or action class'):
        type_name(thing)


def test_the_package_offers_what_it_lists_and_nothing_else() -> None:
    for name in goalwire.idl.__all__:
        assert callable(getattr(goalwire.idl, name))
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        goalwire.idl.nothing  # noqa: B018


# The surface that rosidl_generator_py gives its classes, without the C code behind it.
MESSAGES = """
import array
import numpy
from rosidl_parser.definition import *

class Metaclass_{name}(type):
    _TYPE_SUPPORT = None

class {name}(metaclass=Metaclass_{name}):
    __slots__ = [{slots}]
    _fields_and_field_types = {{{texts}}}
    SLOT_TYPES = ({types})

    def __init__(self, **kwargs):
        for name, value in dict({defaults}).items():
            setattr(self, '_' + name, kwargs.get(name, value))

    @classmethod
    def get_fields_and_field_types(cls):
        return dict(cls._fields_and_field_types)
"""


def write_message(folder: Path, module: str, name: str, fields: dict[str, tuple[str, str, str]]) -> None:
    """Write the module of a class; fields give the text, the slot type and the default of each."""
    source = MESSAGES.format(
        name=name,
        slots=''.join(f"'_{field}', " for field in fields),
        texts=''.join(f"'{field}': '{text}', " for field, (text, _, _) in fields.items()),
        types=''.join(f'{slot}, ' for _, slot, _ in fields.values()),
        defaults=', '.join(f'{field}={default}' for field, (_, _, default) in fields.items()),
    )
    with (folder / f'{module}.py').open('a') as file:
        file.write(source)
    with (folder / '__init__.py').open('a') as file:
        file.write('' if '_' in name else f'from .{module} import {name}\n')


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A regular Python package with generated-looking msg and srv modules."""
    name = fresh_package().replace('_msgs', '_real')
    for folder in (tmp_path / name, tmp_path / name / 'msg', tmp_path / name / 'srv'):
        folder.mkdir()
        (folder / '__init__.py').touch()
    float64, text = "BasicType('double')", 'UnboundedString()'
    write_message(tmp_path / name / 'msg', '_point', 'Point', {'x': ('double', float64, '0.0')})
    write_message(
        tmp_path / name / 'msg',
        '_shape',
        'Shape',
        {
            'name': ('string', text, "''"),
            'size': ('double[2]', f'Array({float64}, 2)', 'numpy.zeros(2)'),
            'points': (
                f'sequence<{name}/Point>',
                f"UnboundedSequence(NamespacedType(['{name}', 'msg'], 'Point'))",
                '[]',
            ),
            'few': ('sequence<int32, 3>', "BoundedSequence(BasicType('int32'), 3)", "array.array('i')"),
        },
    )
    for part in ('Request', 'Response'):
        write_message(
            tmp_path / name / 'srv',
            '_ask',
            f'Ask_{part}',
            {'flag': ('boolean', "BasicType('boolean')", 'False')},
        )
    ask = tmp_path / name / 'srv' / '_ask.py'
    ask.write_text(
        ask.read_text() + 'class Metaclass_Ask(type):\n    _TYPE_SUPPORT = None\n\n'
        'class Ask(metaclass=Metaclass_Ask):\n    Request = Ask_Request\n    Response = Ask_Response\n'
    )
    (tmp_path / name / 'srv' / '__init__.py').write_text('from ._ask import Ask\n')
    monkeypatch.syspath_prepend(str(tmp_path))
    yield name
    for module in [module for module in sys.modules if module.split('.')[0] == name]:
        del sys.modules[module]


def test_a_foreign_message_tells_its_definition(package: str) -> None:
    shape = importlib.import_module(f'{package}.msg').Shape
    assert type_name(shape) == f'{package}/msg/Shape'
    assert own_definition(shape) is None
    assert definition_of(shape) == MessageDefinition(
        package,
        'msg',
        'Shape',
        (
            Field('name', FieldType('string')),
            Field('size', FieldType('float64', Shape.ARRAY, 2)),
            Field('points', FieldType(f'{package}/msg/Point', Shape.UNBOUNDED)),
            Field('few', FieldType('int32', Shape.BOUNDED, 3)),
        ),
    )


def test_a_foreign_message_is_encoded_and_decoded(package: str) -> None:
    module = importlib.import_module(f'{package}.msg')
    message = module.Shape(name='a', points=[module.Point(x=1.5)])
    back = codec.decode(codec.encode(message), module.Shape)
    assert type(back) is module.Shape
    assert (back._name, back._points[0]._x, back._size.tolist()) == ('a', 1.5, [0.0, 0.0])
    with pytest.raises(EncodeTypeError, match=r'Shape: points\[0\].x: expected float, got int 1'):
        codec.encode(module.Shape(points=[module.Point(x=1)]))


def test_its_hash_is_that_of_the_same_definition_as_text(package: str) -> None:
    """Old rosidl has no X_Event classes; the hash needs their definition all the same."""
    ask = importlib.import_module(f'{package}.srv').Ask
    parsed = parse_service('bool flag\n---\nbool flag\n', package, 'Ask')
    told = definition_of(ask)
    assert isinstance(told, ServiceDefinition)
    for ours, theirs in zip(parsed.messages, told.messages, strict=True):
        assert ours.full_name == theirs.full_name
        assert [(field.name, field.type) for field in ours.fields] == [
            (field.name, field.type) for field in theirs.fields
        ]
    assert type_hash(ask) == type_hash(f'{package}/srv/Ask')
    assert definition_by_name(f'{package}/srv/Ask_Event') == told.event


def test_a_type_that_the_foreign_package_lacks_is_unknown(package: str) -> None:
    with pytest.raises(UnknownInterfaceError, match=r'the installed .* has no such type'):
        find_class(f'{package}/msg/Missing')
    with pytest.raises(UnknownInterfaceError, match='has no part of this name'):
        definition_by_name(f'{package}/srv/Ask_Goal')


def test_our_messages_hold_foreign_ones(package: str) -> None:
    point = importlib.import_module(f'{package}.msg').Point
    ours = fresh_package()
    register_definitions(ours, {'msg/Pair': f'{package}/Point[2] points\n{package}/Point one'})
    pair: Any = get_message(f'{ours}/msg/Pair')
    assert type(pair().one) is point
    assert len(codec.encode(pair())) == 4 + 3 * 8


def test_derived_types_of_foreign_services_are_found(package: str) -> None:
    ask = importlib.import_module(f'{package}.srv').Ask
    assert find_class(f'{package}/srv/Ask_Request') is ask.Request


@pytest.mark.parametrize('thing', [int, object, Path, type])
def test_other_classes_have_no_definition(thing: type) -> None:
    with pytest.raises(UnknownInterfaceError):
        definition_of(thing)
