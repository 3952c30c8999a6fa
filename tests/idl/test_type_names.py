"""Classes by name and names by class."""

from __future__ import annotations

import pytest

import goalwire.idl
from goalwire.errors import UnknownInterfaceError
from goalwire.idl import get_action, get_interface, get_message, get_service, type_name


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
    with pytest.raises(UnknownInterfaceError, match='is no message, service or action class'):
        type_name(thing)


def test_the_package_offers_what_it_lists_and_nothing_else() -> None:
    for name in goalwire.idl.__all__:
        assert callable(getattr(goalwire.idl, name))
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        goalwire.idl.nothing  # noqa: B018
