from __future__ import annotations

from uuid import UUID

from goalwire.rules.goals import new_goal_id


def test_an_id_is_a_version_4_uuid() -> None:
    goal_id = UUID(bytes=new_goal_id())
    assert (goal_id.version, goal_id.variant) == (4, 'specified in RFC 4122')


def test_random_bytes_are_kept_but_for_the_six_fixed_bits() -> None:
    assert new_goal_id(b'\xff' * 16) == bytes.fromhex('ffffffffffff4fffbfffffffffffffff')
    assert new_goal_id(bytes(16)) == bytes.fromhex('00000000000040008000000000000000')


def test_ids_differ() -> None:
    assert len({new_goal_id() for _ in range(1000)}) == 1000
