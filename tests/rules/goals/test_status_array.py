from __future__ import annotations

import pytest
from action_msgs.msg import GoalInfo, GoalStatusArray
from action_msgs.msg import GoalStatus as StatusMessage
from builtin_interfaces.msg import Time
from hypothesis import given, settings
from hypothesis import strategies as st
from unique_identifier_msgs.msg import UUID

from goalwire.cdr import codec
from goalwire.errors import RemoteError
from goalwire.rules.goals import GoalStatus, decode_status_array
from goalwire.rules.goals.status_array import StatusArray, statuses_of

# action_msgs/msg/GoalStatusArray of two goals, byte by byte.
FIRST = bytes.fromhex('e491c5b10becb5563bfc1e6f93427ecb')
SECOND = bytes.fromhex('8e46dc8ed4b7c2764d2a5a4d767706f8')
STAMP_OF_FIRST = 2_147_483_647_000_000_000
STAMP_OF_SECOND = 1_784_759_831_128_488_133
TWO_GOALS = bytes.fromhex(
    '00010000' '02000000'
    'e491c5b10becb5563bfc1e6f93427ecb' 'ffffff7f' '00000000' '05'
    '8e46dc8ed4b7c2764d2a5a4d767706f8' '000000' '1746616a' 'c592a807' '02'
)  # fmt: skip


def test_the_payload_is_what_ros_2_writes() -> None:
    statuses = StatusArray()
    statuses.add(FIRST, STAMP_OF_FIRST, GoalStatus.ACCEPTED)
    statuses.add(SECOND, STAMP_OF_SECOND, GoalStatus.ACCEPTED)
    statuses.update(SECOND, GoalStatus.EXECUTING)
    statuses.update(FIRST, GoalStatus.CANCELED)
    assert statuses.take() == TWO_GOALS


def test_an_empty_array_is_a_length_of_zero() -> None:
    assert StatusArray().encode() == bytes.fromhex('0001000000000000')
    assert decode_status_array(StatusArray().encode()) == []


def test_it_is_taken_once_for_each_change() -> None:
    statuses = StatusArray()
    assert statuses.take() is None
    statuses.add(FIRST, 1, GoalStatus.ACCEPTED)
    assert statuses.take() is not None
    assert statuses.take() is None


def test_goals_stay_in_the_order_of_their_acceptance() -> None:
    statuses = StatusArray()
    for goal_id in (SECOND, FIRST):
        statuses.add(goal_id, 1, GoalStatus.ACCEPTED)
    statuses.update(SECOND, GoalStatus.EXECUTING)
    assert decode_status_array(statuses.encode()) == [
        (SECOND, GoalStatus.EXECUTING),
        (FIRST, GoalStatus.ACCEPTED),
    ]


def test_a_goal_leaves_only_after_its_end_was_taken() -> None:
    statuses = StatusArray()
    statuses.add(FIRST, 1, GoalStatus.ACCEPTED)
    statuses.update(FIRST, GoalStatus.ABORTED)
    statuses.remove(FIRST)
    last = statuses.take()
    assert last is not None
    assert decode_status_array(last) == [(FIRST, GoalStatus.ABORTED)]
    assert len(statuses) == 0


def test_a_goal_whose_end_was_taken_leaves_at_once_and_without_an_array() -> None:
    statuses = StatusArray()
    statuses.add(FIRST, 1, GoalStatus.SUCCEEDED)
    statuses.take()
    statuses.remove(FIRST)
    assert (len(statuses), statuses.take()) == (0, None)


def test_an_id_that_comes_again_while_its_end_waits_to_be_taken_is_a_new_goal() -> None:
    statuses = StatusArray()
    statuses.add(FIRST, 1, GoalStatus.SUCCEEDED)
    statuses.remove(FIRST)
    statuses.add(FIRST, 2, GoalStatus.ACCEPTED)
    statuses.take()
    assert decode_status_array(statuses.encode()) == [(FIRST, GoalStatus.ACCEPTED)]


def test_both_byte_orders_are_read() -> None:
    big = b'\x00\x00\x00\x00' + (2).to_bytes(4, 'big') + TWO_GOALS[8:]
    expected = [(FIRST, GoalStatus.CANCELED), (SECOND, GoalStatus.EXECUTING)]
    assert decode_status_array(TWO_GOALS) == expected
    assert decode_status_array(big) == expected


@pytest.mark.parametrize('end', range(len(TWO_GOALS)))
def test_a_truncated_array_is_refused(end: int) -> None:
    with pytest.raises(RemoteError):
        decode_status_array(TWO_GOALS[:end])


def test_a_hostile_length_is_refused_without_reading_on() -> None:
    with pytest.raises(RemoteError, match='4294967295 entries'):
        decode_status_array(TWO_GOALS[:4] + b'\xff\xff\xff\xff' + TWO_GOALS[8:])


def test_an_unheard_of_status_is_refused() -> None:
    with pytest.raises(RemoteError, match='beyond ABORTED'):
        decode_status_array(TWO_GOALS[:-1] + b'\x7f')


def test_padding_behind_the_array_is_let_pass_but_nothing_more() -> None:
    assert decode_status_array(TWO_GOALS + bytes(3)) == decode_status_array(TWO_GOALS)
    with pytest.raises(RemoteError):
        decode_status_array(TWO_GOALS + bytes(4))


@given(
    st.lists(
        st.tuples(st.binary(min_size=16, max_size=16), st.sampled_from(GoalStatus)), unique_by=lambda e: e[0]
    )
)
def test_what_is_encoded_is_decoded(entries: list[tuple[bytes, GoalStatus]]) -> None:
    statuses = StatusArray()
    for goal_id, status in entries:
        statuses.add(goal_id, 1_500_000_000, status)
    assert decode_status_array(statuses.encode()) == entries


WRITE = codec.encoder(GoalStatusArray)
GOALS = st.sampled_from([bytes(16), b'\0' * 15 + b'\1', b'\xff' * 16, FIRST, SECOND])
STAMPS = st.integers(-(2**31) * 10**9, (2**31) * 10**9 - 1)
Step = tuple[str, bytes, int, GoalStatus]
ACTS = st.sampled_from(['add', 'update', 'remove', 'take'])
STEPS = st.tuples(ACTS, GOALS, STAMPS, st.sampled_from(GoalStatus))


def message(entries: dict[bytes, tuple[int, GoalStatus]]) -> GoalStatusArray:
    return GoalStatusArray(
        status_list=[
            StatusMessage(
                goal_info=GoalInfo(
                    goal_id=UUID(uuid=list(goal_id)), stamp=Time(sec=stamp // 10**9, nanosec=stamp % 10**9)
                ),
                status=int(status),
            )
            for goal_id, (stamp, status) in entries.items()
        ]
    )


@settings(deadline=None)
@given(st.lists(STEPS, max_size=40))
def test_whatever_happens_it_is_what_the_codec_writes(steps: list[Step]) -> None:
    statuses, entries = StatusArray(), dict[bytes, tuple[int, GoalStatus]]()
    for step, goal_id, stamp, status in steps:
        if step == 'add':
            entries.pop(goal_id, None)
            entries[goal_id] = stamp, status
            statuses.add(goal_id, stamp, status)
        elif step == 'update' and goal_id in entries:
            entries[goal_id] = entries[goal_id][0], status
            statuses.update(goal_id, status)
        elif step == 'remove' and goal_id in entries:
            del entries[goal_id]
            statuses.remove(goal_id)
            statuses.take()
        elif step == 'take':
            statuses.take()
        assert statuses.encode() == WRITE(message(entries))


@settings(deadline=None)
@given(st.data())
def test_followed_goals_are_found_as_if_everything_was_decoded(data: st.DataObject) -> None:
    """Ids, stamps and paddings of zeros and ones look alike: only their places tell them apart."""
    few = st.sampled_from(b'\0\1')
    ids = st.lists(few, min_size=16, max_size=16).map(bytes)
    entries = data.draw(st.dictionaries(ids, st.tuples(st.integers(0, 3), st.sampled_from(GoalStatus))))
    followed = data.draw(st.sets(st.sampled_from(sorted(entries)) | ids if entries else ids, max_size=24))
    payload = WRITE(message(entries)) + bytes(data.draw(st.integers(0, 3)))
    everything = decode_status_array(payload)
    assert statuses_of(followed, payload) == [entry for entry in everything if entry[0] in followed]


@pytest.mark.parametrize('goals', [{FIRST}, {bytes((n,)) * 16 for n in range(20)}])
@pytest.mark.parametrize('wrong', [TWO_GOALS[:-1], TWO_GOALS[:-1] + b'\x07', TWO_GOALS[:8], b'', bytes(64)])
def test_an_array_is_judged_whole_whoever_is_followed(goals: set[bytes], wrong: bytes) -> None:
    with pytest.raises(RemoteError):
        statuses_of(goals, wrong)


def test_bytes_that_only_look_like_a_goal_are_not_one() -> None:
    across = TWO_GOALS[14:30]
    assert statuses_of({across}, TWO_GOALS) == []
    assert statuses_of({FIRST}, TWO_GOALS) == [(FIRST, GoalStatus.CANCELED)]
