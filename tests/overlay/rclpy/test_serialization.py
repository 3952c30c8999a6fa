from __future__ import annotations

import pytest
from rclpy.exceptions import NoTypeSupportImportedException
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.type_support import (
    check_for_type_support,
    check_is_valid_msg_type,
    check_is_valid_srv_type,
)
from std_msgs.msg import Empty, Float64, String
from std_srvs.srv import SetBool

from goalwire.errors import DecodeError, EncodeError

AB = b'\x00\x01\x00\x00\x03\x00\x00\x00ab\x00'


@pytest.mark.parametrize(
    ('message', 'data'),
    [
        (String(data='ab'), AB),
        (Float64(data=1.0), b'\x00\x01\x00\x00\x00\x00\x00\x00\x00\x00\xf0?'),
        (Empty(), b'\x00\x01\x00\x00\x00'),
        (SetBool.Request(data=True), b'\x00\x01\x00\x00\x01'),
    ],
)
def test_a_message_becomes_cdr_and_comes_back(message: object, data: bytes) -> None:
    assert serialize_message(message) == data
    assert deserialize_message(data, type(message)) == message


@pytest.mark.parametrize('kind', [bytes, bytearray, memoryview])
def test_any_bytes_are_read(kind: type) -> None:
    assert deserialize_message(kind(AB), String) == String(data='ab')


@pytest.mark.parametrize('extra', [1, 7, 8, 16, 32, 1000])
def test_what_follows_a_message_is_ignored(extra: int) -> None:
    assert deserialize_message(AB + b'\xff' * extra, String) == String(data='ab')
    assert deserialize_message(bytearray(AB + bytes(extra)), String) == String(data='ab')


@pytest.mark.parametrize('data', ['x', None, [1, 2]])
def test_what_is_no_bytes_is_refused(data: object) -> None:
    with pytest.raises(TypeError, match='a serialized message is bytes, bytearray or memoryview, not '):
        deserialize_message(data, String)  # type: ignore[arg-type]


@pytest.mark.parametrize('data', [b'', b'\x00\x01', b'\x00\x01\x00\x00\xff\x00\x00\x00ab\x00'])
def test_short_data_is_refused(data: bytes) -> None:
    with pytest.raises(DecodeError, match='std_msgs/msg/String'):
        deserialize_message(data, String)


def test_a_wrong_value_is_refused_with_its_field() -> None:
    with pytest.raises(EncodeError, match=r'std_msgs/msg/String: data: .*1'):
        serialize_message(String(data=1))  # type: ignore[arg-type]


@pytest.mark.parametrize('thing', [1, String, SetBool])
def test_only_messages_are_serialized(thing: object) -> None:
    with pytest.raises(AttributeError, match='a class of a message, a service or an action is needed'):
        serialize_message(thing)


def test_only_message_classes_are_deserialized() -> None:
    with pytest.raises(AttributeError, match='a class of a message, a service or an action is needed'):
        deserialize_message(AB, int)
    with pytest.raises(RuntimeError, match='is a service, and a message is needed'):
        deserialize_message(AB, SetBool)


def test_classes_are_told_apart() -> None:
    check_for_type_support(String)
    check_for_type_support(SetBool)
    check_is_valid_msg_type(SetBool.Request)
    check_is_valid_srv_type(SetBool)
    with pytest.raises(RuntimeError, match='SetBool is a service, and a message is needed'):
        check_is_valid_msg_type(SetBool)
    with pytest.raises(
        RuntimeError, match=r'The service type provided is not valid: .* and a service is needed'
    ):
        check_is_valid_srv_type(String)
    with pytest.raises(AttributeError, match='a class of a message, a service or an action is needed'):
        check_for_type_support(int)


class Unsupported(type):
    """The metaclass of message classes whose C code is missing."""

    _TYPE_SUPPORT = None
    asked = 0

    @classmethod
    def __import_type_support__(cls) -> None:
        cls.asked += 1


class Unbuilt(metaclass=Unsupported):
    pass


def test_a_class_without_type_support_is_told_apart_too() -> None:
    with pytest.raises(NoTypeSupportImportedException):
        check_for_type_support(Unbuilt)
    assert Unsupported.asked == 1
