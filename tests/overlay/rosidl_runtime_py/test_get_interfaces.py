"""Which packages define which interfaces, and where."""

from __future__ import annotations

from importlib import invalidate_caches
from pathlib import Path

import pytest
from helpers.packages import write_package
from rosidl_runtime_py import (
    get_action_interfaces,
    get_interface_packages,
    get_interface_path,
    get_interfaces,
    get_message_interfaces,
    get_service_interfaces,
)


@pytest.fixture
def zoo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of an interface package zoo_msgs."""
    files = {
        'msg/Lion.msg': 'int32 teeth\n',
        'msg/Ape.msg': '',
        'srv/Feed.srv': '---\n',
        'action/Nap.action': '---\n---\n',
    }
    monkeypatch.setenv('GOALWIRE_INTERFACE_PATH', str(tmp_path))
    invalidate_caches()
    return write_package(tmp_path / 'zoo_msgs', 'zoo_msgs', files)


def test_interfaces_are_listed_by_package_and_kind(zoo: Path) -> None:
    assert get_interfaces(['zoo_msgs']) == {'zoo_msgs': ['action/Nap', 'msg/Ape', 'msg/Lion', 'srv/Feed']}
    assert get_message_interfaces(['zoo_msgs']) == {'zoo_msgs': ['msg/Ape', 'msg/Lion']}
    assert get_service_interfaces(['zoo_msgs']) == {'zoo_msgs': ['srv/Feed']}
    assert get_action_interfaces(['zoo_msgs']) == {'zoo_msgs': ['action/Nap']}


def test_without_names_all_packages_are_listed(zoo: Path) -> None:
    found = get_interfaces()
    assert found['zoo_msgs'] == ['action/Nap', 'msg/Ape', 'msg/Lion', 'srv/Feed']
    assert 'msg/String' in found['std_msgs']
    assert {'zoo_msgs', 'std_msgs'} <= set(get_interface_packages())


def test_a_package_without_interfaces_of_the_kind_is_left_out() -> None:
    assert get_message_interfaces(['std_srvs']) == {}
    assert get_action_interfaces(['example_interfaces']) == {'example_interfaces': ['action/Fibonacci']}


@pytest.mark.parametrize('name', ['nope', 'No Package', 'x'])
def test_an_unknown_package_is_a_lookup_error(name: str) -> None:
    with pytest.raises(LookupError, match=f"Unknown package '{name}'"):
        get_message_interfaces([name])


def test_the_path_of_an_interface_is_its_file(zoo: Path) -> None:
    assert get_interface_path('zoo_msgs/msg/Lion') == str(zoo / 'msg' / 'Lion.msg')
    assert get_interface_path('zoo_msgs/srv/Feed') == str(zoo / 'srv' / 'Feed.srv')
    assert get_interface_path('zoo_msgs/msg/Lion.msg') == str(zoo / 'msg' / 'Lion.msg')
    assert get_interface_path('std_msgs/msg/String').split('/share/')[-1] == 'std_msgs/msg/String.msg'


@pytest.mark.parametrize('name', ['std_msgs/msg/Nope', 'std_msgs/msg/String.idl'])
def test_a_missing_interface_is_a_lookup_error_that_names_its_file(name: str) -> None:
    with pytest.raises(LookupError, match=r'Could not find the interface .*/share/std_msgs/msg/'):
        get_interface_path(name)


def test_a_missing_package_is_a_lookup_error() -> None:
    with pytest.raises(LookupError, match="Unknown package 'nope'"):
        get_interface_path('nope/msg/String')


@pytest.mark.parametrize('name', ['String', 'std_msgs/', 'std_msgs//String', 'std_msgs/ msg/String'])
def test_a_malformed_name_is_a_value_error(name: str) -> None:
    with pytest.raises(ValueError, match='Invalid interface name'):
        get_interface_path(name)
