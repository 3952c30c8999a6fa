"""Interface classes by their names."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from rosidl_parser.definition import NamespacedType
from rosidl_runtime_py.utilities import (
    get_action,
    get_action_namespaced_type,
    get_interface,
    get_message,
    get_message_namespaced_type,
    get_namespaced_type,
    get_service,
    get_service_namespaced_type,
    import_message_from_namespaced_type,
    is_action,
    is_message,
    is_service,
)
from std_msgs.msg import String
from std_srvs.srv import Trigger

Getter = Callable[[str], type]


@pytest.mark.parametrize(
    ('get', 'name', 'cls'),
    [
        (get_message, 'std_msgs/msg/String', String),
        (get_message, 'std_msgs/String', String),
        (get_interface, 'std_msgs/msg/String', String),
        (get_service, 'std_srvs/srv/Trigger', Trigger),
        (get_service, 'std_srvs/Trigger', Trigger),
        (get_action, 'example_interfaces/action/Fibonacci', Fibonacci),
        (get_action, 'example_interfaces/Fibonacci', Fibonacci),
        (get_interface, 'std_srvs/srv/Trigger_Request', Trigger.Request),
    ],
)
def test_a_class_is_found_by_its_name(get: Getter, name: str, cls: type) -> None:
    assert get(name) is cls


@pytest.mark.parametrize(
    ('get', 'name', 'error', 'text'),
    [
        (get_message, 'std_msgs/msg/Nope', AttributeError, "module 'std_msgs.msg' has no attribute 'Nope'"),
        (get_message, 'nope/msg/String', ModuleNotFoundError, "No module named 'nope'"),
        (get_message, 'String', ValueError, 'Empty module name'),
        (get_message, '', ValueError, 'Empty module name'),
        (
            get_message,
            'std_srvs/srv/Trigger',
            ValueError,
            "Expected the full name of a message, got 'std_srvs/srv/Trigger'",
        ),
        (
            get_service,
            'std_msgs/msg/String',
            ValueError,
            "Expected the full name of a service, got 'std_msgs/msg/String'",
        ),
        (
            get_action,
            'std_msgs/msg/String',
            ValueError,
            "Expected the full name of an action, got 'std_msgs/msg/String'",
        ),
        (
            get_interface,
            'std_msgs/String',
            AttributeError,
            (
                "module 'std_msgs' has no attribute 'String': types are one level below; write: "
                'from std_msgs.msg import String'
            ),
        ),
        (get_interface, 'a/b/c/d', ModuleNotFoundError, "No module named 'a'"),
    ],
)
def test_a_name_without_a_class_is_an_error(
    get: Getter, name: str, error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as caught:
        get(name)
    assert str(caught.value) == text


def test_kinds_are_told_apart() -> None:
    kinds = [(is_message(cls), is_service(cls), is_action(cls)) for cls in (String, AddTwoInts, Fibonacci)]
    assert kinds == [(True, False, False), (False, True, False), (False, False, True)]


def test_names_are_split_into_namespaces() -> None:
    assert get_namespaced_type('std_msgs/msg/String') == NamespacedType(['std_msgs', 'msg'], 'String')
    assert get_namespaced_type('x') == NamespacedType([], 'x')


def test_a_namespaced_type_is_imported() -> None:
    assert import_message_from_namespaced_type(NamespacedType(['std_msgs', 'msg'], 'String')) is String


@pytest.mark.parametrize(
    ('find', 'kind'),
    [
        (get_message_namespaced_type, 'msg'),
        (get_service_namespaced_type, 'srv'),
        (get_action_namespaced_type, 'action'),
    ],
)
def test_the_kind_of_a_namespaced_type_may_be_left_out(
    find: Callable[[str], NamespacedType], kind: str
) -> None:
    wanted = NamespacedType(['some_pkg', kind], 'Name')
    assert find('some_pkg/Name') == find(f'some_pkg/{kind}/Name') == wanted
