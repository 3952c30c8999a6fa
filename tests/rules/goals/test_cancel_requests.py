from __future__ import annotations

from dataclasses import dataclass

import pytest

from goalwire.rules.goals import NO_ID, CancelCode, GoalStatus
from goalwire.rules.goals.cancel_requests import choose


@dataclass
class Goal:
    stamp_ns: int
    status: GoalStatus


A, B, C, D = (bytes([n]) * 16 for n in range(1, 5))
GOALS = {
    A: Goal(10, GoalStatus.EXECUTING),
    B: Goal(20, GoalStatus.SUCCEEDED),
    C: Goal(30, GoalStatus.CANCELING),
    D: Goal(40, GoalStatus.ACCEPTED),
}


@pytest.mark.parametrize(
    ('goal_id', 'stamp_ns', 'code', 'chosen'),
    [
        (NO_ID, 0, CancelCode.NONE, (A, D)),
        (NO_ID, 9, CancelCode.NONE, ()),
        (NO_ID, 10, CancelCode.NONE, (A,)),
        (NO_ID, 39, CancelCode.NONE, (A,)),
        (NO_ID, 40, CancelCode.NONE, (A, D)),
        (A, 0, CancelCode.NONE, (A,)),
        (D, 0, CancelCode.NONE, (D,)),
        (B, 0, CancelCode.GOAL_TERMINATED, ()),
        (C, 0, CancelCode.GOAL_TERMINATED, ()),
        (b'?' * 16, 0, CancelCode.UNKNOWN_GOAL_ID, ()),
        (D, 1, CancelCode.NONE, (D,)),
        (D, 10, CancelCode.NONE, (A, D)),
        (B, 10, CancelCode.NONE, (A,)),
        (b'?' * 16, 10, CancelCode.NONE, (A,)),
    ],
)
def test_id_and_stamp_choose_goals(
    goal_id: bytes, stamp_ns: int, code: CancelCode, chosen: tuple[bytes, ...]
) -> None:
    assert choose(GOALS, goal_id, stamp_ns) == (code, chosen)


def test_with_nothing_active_everything_is_nothing() -> None:
    assert choose({}, NO_ID, 0) == (CancelCode.NONE, ())


def test_codes_are_those_of_the_wire() -> None:
    assert [code.value for code in CancelCode] == [0, 1, 2, 3]
