"""A message in parts: it is copied once, whole, to its place, and not at all if another thread changes it."""

from __future__ import annotations

from array import array
from typing import Any

import pytest

from goalwire.errors import EncodeError
from goalwire.payload_parts import Part, Parts


def parts_of(*parts: Part) -> Parts:
    return Parts(parts, sum(memoryview(part).nbytes for part in parts), 'some_msgs/msg/Numbers')


def test_the_parts_are_written_one_after_the_other() -> None:
    numbers: array[Any] = array('d', [1.5, -2.0])
    parts = parts_of(b'head', numbers, memoryview(array('H', [7, 8])), bytearray(b'tail'))
    expected = b'head' + numbers.tobytes() + array('H', [7, 8]).tobytes() + b'tail'
    assert len(parts) == len(expected)
    assert bytes(parts) == expected
    place = bytearray(len(parts) + 2)
    with memoryview(place) as view:
        parts.write_to(view[1:-1])
    assert place == b'\0' + expected + b'\0'


@pytest.mark.parametrize('change', [lambda numbers: numbers.append(1), lambda numbers: numbers.pop()])
def test_a_message_that_changes_its_length_meanwhile_is_refused(change: Any) -> None:
    numbers: array[Any] = array('B', bytes(10))
    parts = parts_of(b'head', numbers)
    change(numbers)
    with pytest.raises(EncodeError, match='some_msgs/msg/Numbers: the message changed its length'):
        bytes(parts)
    with pytest.raises(EncodeError, match='before publish'):
        parts.write_to(memoryview(bytearray(14)))
