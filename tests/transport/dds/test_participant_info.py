"""ros_discovery_info in both forms, against what a real node sent."""

from __future__ import annotations

import pytest
from helpers.captured import Captured
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import RemoteError
from goalwire.transport.dds.participant_info import (
    OLD_GID_SIZE,
    NodeInfo,
    ParticipantInfo,
    decode,
    encode,
)

GID = bytes(range(1, 17))
NODES = (
    NodeInfo('/', 'alpha', (bytes([1]) * 16, bytes([2]) * 16), (bytes([3]) * 16,)),
    NodeInfo('/fleet/robot_1', 'b'),
)


def test_a_real_nodes_message_is_read_and_written_byte_for_byte(captured: list[Captured]) -> None:
    (message,) = [each for each in captured if each.topic == 'ros_discovery_info']
    info = decode(message.payload)
    (node,) = info.nodes
    assert (node.namespace, node.name) == ('/', 'real_cli')
    assert (len(node.readers), len(node.writers)) == (8, 9)
    assert info.gid.hex() == '0110818782581a1870b48788000001c1'
    assert encode(info) == message.payload


@pytest.mark.parametrize('size', [16, OLD_GID_SIZE])
@pytest.mark.parametrize('nodes', [(), NODES])
def test_both_forms_are_told_apart(size: int, nodes: tuple[NodeInfo, ...]) -> None:
    info = ParticipantInfo(GID, nodes)
    assert decode(encode(info, size)) == info


@pytest.mark.parametrize('size', [16, OLD_GID_SIZE])
def test_a_message_that_is_cut_short_is_refused(size: int) -> None:
    whole = encode(ParticipantInfo(GID, NODES), size)
    empty = set(range(24, 28))  # what ends here is a whole message of the newer form, without nodes
    for length in set(range(len(whole) - 1)) - empty:
        with pytest.raises(RemoteError, match='ros_discovery_info'):
            decode(whole[:length])


@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(raw: bytes) -> None:
    try:
        decode(b'\0\1\0\0' + raw)
    except RemoteError as error:
        assert 'ros_discovery_info' in str(error)  # noqa: PT017 - either way is right


def test_counts_beyond_the_message_are_refused_before_anything_is_made_of_them() -> None:
    with pytest.raises(RemoteError, match='4294967295 items do not fit'):
        decode(b'\0\1\0\0' + GID + b'\xff' * 4)
