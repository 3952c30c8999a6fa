"""An action client of plain zenoh: goals done, cancelled, aborted and refused. Argument: hashes as JSON."""

import json
import queue
import struct
import sys
import uuid
from itertools import count

import zenoh
from raw_action import (  # type: ignore[import-not-found]
    DOMAIN,
    HEADER,
    attachment,
    connect,
    direct,
    keys,
    read_numbers,
)

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
KEYS = keys(json.loads(sys.argv[1]))
session = connect()
sequences = {part: count(1).__next__ for part in ('send_goal', 'get_result', 'cancel_goal')}
queriers = {
    part: session.declare_querier(
        f'{DOMAIN}/{KEYS[part]}',
        target=zenoh.QueryTarget.ALL_COMPLETE,
        consolidation=zenoh.ConsolidationMode.NONE,
        timeout=20.0,
    )
    for part in sequences
}
feedback: queue.SimpleQueue[bytes] = queue.SimpleQueue()
statuses: queue.SimpleQueue[bytes] = queue.SimpleQueue()
subscribers = [
    session.declare_subscriber(
        f'{DOMAIN}/{KEYS[part]}', direct(lambda sample, heard=heard: heard.put(sample.payload.to_bytes()))
    )
    for part, heard in (('feedback', feedback), ('status', statuses))
]


def wait_for_server() -> None:
    """Wait until each of the three services is there."""
    for querier in queriers.values():
        found: queue.SimpleQueue[bool] = queue.SimpleQueue()
        listener = querier.declare_matching_listener(
            direct(lambda status, found=found: status.matching and found.put(True))
        )
        assert querier.matching_status.matching or found.get(timeout=20.0)
        listener.undeclare()


def call(part: str, body: bytes) -> bytes:
    """Make a request; return the body of its only reply."""
    sequence = sequences[part]()
    replies = list(queriers[part].get(payload=HEADER + body, attachment=attachment(sequence)))
    assert len(replies) == 1, f'{part}: {len(replies)} replies'
    sample = replies[0].ok
    assert sample is not None
    assert sample.attachment is not None
    assert sample.attachment.to_bytes()[:8] == struct.pack('<q', sequence)
    data = sample.payload.to_bytes()
    assert data[:4] == HEADER
    return bytes(data[4:])


def next_feedback(goal: bytes) -> list[int]:
    data = feedback.get(timeout=10.0)
    assert data[4:20] == goal
    return list(read_numbers(data[20:]))


def last_status(goal: bytes) -> int:
    """Wait for an array in which the goal has ended.

    An entry is 16 bytes of id, two words of time on a multiple of 4, and one byte: 28 bytes with the padding,
    which stands behind the id in all entries but the first.
    """
    while True:
        data = statuses.get(timeout=10.0)[4:]
        (size,) = struct.unpack_from('<I', data)
        for each in range(size):
            at = 28 * each + (1 if each else 4)
            status = data[28 * (each + 1)]
            if data[at : at + 16] == goal and status >= SUCCEEDED:
                return status


def result(goal: bytes) -> tuple[int, list[int]]:
    body = call('get_result', goal)
    return body[0], read_numbers(body[4:])


wait_for_server()
goal = uuid.uuid4().bytes
assert call('send_goal', goal + struct.pack('<i', 6))[0] == 1
assert [next_feedback(goal)[-1] for _ in range(5)] == [1, 2, 3, 5, 8]
assert result(goal) == (SUCCEEDED, [0, 1, 1, 2, 3, 5, 8])
assert last_status(goal) == SUCCEEDED
print('one goal succeeded')

goal = uuid.uuid4().bytes
assert call('send_goal', goal + struct.pack('<i', 10_000))[0] == 1
for _ in range(3):
    next_feedback(goal)
answer = call('cancel_goal', goal + bytes(8))
assert answer[0] == 0
assert struct.unpack_from('<I', answer, 4) == (1,)
assert answer[8:24] == goal
status, sequence = result(goal)
assert status == CANCELED
assert sequence[:5] == [0, 1, 1, 2, 3]
assert last_status(goal) == CANCELED
print('one goal was canceled')

goal = uuid.uuid4().bytes
assert call('send_goal', goal + struct.pack('<i', 60))[0] == 1  # its numbers leave int32: execution raises
assert result(goal) == (ABORTED, [])  # as it is, whatever follows
assert last_status(goal) == ABORTED
print('one goal was aborted')

goal = uuid.uuid4().bytes
assert call('send_goal', goal + struct.pack('<i', -1))[0] == 0
assert result(goal) == (0, [])
print('one goal was refused')
session.close()
