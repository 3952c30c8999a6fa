"""Loaned messages: the bytes are those of an ordinary message, and a loan ends when it is published."""

from __future__ import annotations

from array import array
from typing import Any

import pytest
from sensor_msgs.msg import Image, PointCloud2
from std_msgs.msg import Float64MultiArray, String

from goalwire.cdr.codec import decode, encode, parts_encoder
from goalwire.entities.loans import HEAD_ROOM, LoanedMessage, OwnMemory, borrow, publish
from goalwire.transport.contract import PublisherPort


class Port(PublisherPort):
    """A port without memory of its own, which keeps what is published."""

    def __init__(self) -> None:
        self.gid = bytes(16)
        self.published: list[bytes] = []

    def publish(self, payload: bytes) -> None:
        self.published.append(payload)

    def close(self) -> None:
        pass


@pytest.fixture
def port() -> Port:
    return Port()


def filled(message: Any, numbers: array[Any]) -> Any:
    """Return a message with some fields set, and these numbers written into its sequence."""
    message.data[:] = numbers
    if isinstance(message, (Image, PointCloud2)):
        message.header.frame_id, message.height = 'camera', 7
    if isinstance(message, PointCloud2):
        message.is_dense = True
    return message


@pytest.mark.parametrize('cls', [Image, PointCloud2, Float64MultiArray])
def test_the_bytes_are_those_of_an_ordinary_message(port: Port, cls: type) -> None:
    numbers: array[Any] = array('d' if cls is Float64MultiArray else 'B', range(100))
    ordinary = filled(cls(data=numbers), numbers)
    loaned: LoanedMessage[Any] = borrow(port, cls, {'data': 100})
    filled(loaned.get(), numbers)
    publish(port, loaned)
    assert port.published == [encode(ordinary)]
    assert decode(port.published[0], cls) == ordinary
    assert b''.join(parts_encoder(cls)(ordinary)) == encode(ordinary)


def test_a_loan_ends_when_it_is_published(port: Port) -> None:
    loaned: LoanedMessage[Image] = borrow(port, Image, {'data': 10})
    data = loaned.get().data
    publish(port, loaned)
    with pytest.raises(ValueError, match='released'):
        data[0]
    with pytest.raises(ValueError, match='borrow another one'):
        loaned.get()
    with pytest.raises(ValueError, match='borrow another one'):
        publish(port, loaned)
    assert len(port.published) == 1


def test_a_loan_that_is_not_published_ends_with_its_block(port: Port) -> None:
    loaned: LoanedMessage[Image]
    with borrow(port, Image, {'data': 10}) as loaned:
        loaned.get().height = 1
    with pytest.raises(ValueError, match='given back'):
        loaned.get()
    assert port.published == []


def test_other_numbers_in_the_place_of_the_loaned_ones_are_published(port: Port) -> None:
    loaned: LoanedMessage[Image] = borrow(port, Image, {'data': 10})
    loaned.get().data = array('B', b'others')
    publish(port, loaned)
    assert decode(port.published[0], Image).data == array('B', b'others')


def test_a_head_without_room_is_published_by_copying(port: Port) -> None:
    loaned: LoanedMessage[Image] = borrow(port, Image, {'data': 3})
    loaned.get().header.frame_id = 'x' * HEAD_ROOM
    loaned.get().data[:] = array('B', b'abc')
    publish(port, loaned)
    assert decode(port.published[0], Image).data == array('B', b'abc')


@pytest.mark.parametrize('lengths', [{}, {'encoding': 3}, {'data': 1, 'step': 1}, {'nothing': 1}])
def test_only_one_sequence_of_numbers_is_lent(port: Port, lengths: dict[str, int]) -> None:
    with pytest.raises(TypeError, match='one sequence of numbers: data=1000'):
        borrow(port, Image, lengths)


def test_a_type_without_numbers_says_so(port: Port) -> None:
    with pytest.raises(TypeError, match='the message has none, so publish it as it is'):
        borrow(port, String, {'data': 3})


def test_a_negative_length_is_refused(port: Port) -> None:
    with pytest.raises(ValueError, match='data=-1'):
        borrow(port, Image, {'data': -1})
    assert OwnMemory(3).view.nbytes == 3
