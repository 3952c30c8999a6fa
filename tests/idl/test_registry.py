"""Definitions by name: files, registered text, and clear words where something is missing."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.names import fresh_package

from goalwire.errors import InterfaceError, InterfaceSyntaxError, UnknownInterfaceError
from goalwire.idl import registry
from goalwire.idl.model import ActionDefinition, MessageDefinition, ServiceDefinition


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty interface package on the search path."""
    folder = tmp_path / fresh_package()
    (folder / 'msg').mkdir(parents=True)
    monkeypatch.setenv('GOALWIRE_INTERFACE_PATH', str(tmp_path))
    return folder


def test_a_definition_is_parsed_once() -> None:
    assert registry.definition('std_msgs/msg/String') is registry.definition('std_msgs/msg/String')


def test_derived_types_are_found_by_their_names() -> None:
    assert isinstance(registry.definition('std_srvs/srv/SetBool_Event'), MessageDefinition)
    assert isinstance(registry.definition('example_interfaces/action/Fibonacci'), ActionDefinition)
    assert isinstance(registry.definition('example_interfaces/action/Fibonacci_SendGoal'), ServiceDefinition)
    found = registry.definition('example_interfaces/action/Fibonacci_SendGoal_Request')
    assert isinstance(found, MessageDefinition)
    assert [field.name for field in found.fields] == ['goal_id', 'goal']


def test_registered_text_is_found() -> None:
    name = fresh_package()
    registry.register_definitions(name, {'msg/Foo': 'int32 x', 'srv/Bar': 'Foo foo\n---\n'})
    assert registry.message_definition(f'{name}/srv/Bar_Request').fields[0].type.base == f'{name}/msg/Foo'
    assert registry.registered_types(name) == {'msg/Foo', 'srv/Bar'}


def test_the_same_text_may_be_registered_again_but_no_other() -> None:
    name = fresh_package()
    registry.register_definitions(name, {'msg/Foo': 'int32 x'})
    registry.definition(f'{name}/msg/Foo')
    registry.register_definitions(name, {'msg/Foo': 'int32 x'})
    with pytest.raises(InterfaceError, match='already defined differently'):
        registry.register_definitions(name, {'msg/Foo': 'int32 y'})


def test_malformed_text_is_refused_when_it_is_registered() -> None:
    name = fresh_package()
    with pytest.raises(InterfaceSyntaxError, match=f'{name}/msg/Foo.msg:2:1: '):
        registry.register_definitions(name, {'msg/Foo': 'int32 x\nint3 y'})
    assert registry.registered_types(name) == frozenset()


def test_a_malformed_file_is_named_with_its_line_and_the_others_still_work(package: Path) -> None:
    (package / 'msg' / 'Bad.msg').write_text('int32 a\nfloat b\n')
    (package / 'msg' / 'Good.msg').write_text('int32 a\n')
    with pytest.raises(InterfaceSyntaxError) as caught:
        registry.definition(f'{package.name}/msg/Bad')
    assert str(caught.value) == f"{package / 'msg' / 'Bad.msg'}:2:1: 'float' is not a type (write float32)"
    assert registry.message_definition(f'{package.name}/msg/Good').fields[0].name == 'a'


def test_a_file_that_is_no_text_is_named_with_its_line(package: Path) -> None:
    (package / 'msg' / 'Bad.msg').write_bytes(b'int32 a\n# caf\xe9\n')
    with pytest.raises(InterfaceSyntaxError, match=r'Bad.msg:2:1: this line is not UTF-8 text'):
        registry.definition(f'{package.name}/msg/Bad')


def test_a_byte_order_mark_does_no_harm(package: Path) -> None:
    (package / 'msg' / 'Marked.msg').write_bytes(b'\xef\xbb\xbfint32 a\n')
    assert registry.message_definition(f'{package.name}/msg/Marked').fields[0].name == 'a'


def test_an_unknown_type_names_the_folder_and_what_is_close() -> None:
    with pytest.raises(UnknownInterfaceError, match=r'std_msgs/msg/Strin: .*std_msgs; close: msg/String'):
        registry.definition('std_msgs/msg/Strin')


def test_an_unknown_package_says_what_to_do() -> None:
    with pytest.raises(
        UnknownInterfaceError, match=r"no package 'nowhere_msgs' was found .*GOALWIRE_INTERFACE_PATH"
    ):
        registry.definition('nowhere_msgs/msg/Foo')


@pytest.mark.parametrize(
    'name',
    [
        'String',
        'std_msgs/String',
        'std_msgs/topic/String',
        'a/msg/b/c',
        '',
        '//',
        '../msg/String',
        '.hidden/msg/String',
        'os.path/msg/String',
        'std_msgs/msg/..',
        'std_msgs/msg/A\0',
    ],
)
def test_what_is_no_full_name_is_refused(name: str) -> None:
    with pytest.raises(UnknownInterfaceError, match='is not an interface name'):
        registry.definition(name)


def test_a_service_has_no_part_of_another_name() -> None:
    with pytest.raises(UnknownInterfaceError, match='has no part of this name'):
        registry.definition('std_srvs/srv/SetBool_Goal')
