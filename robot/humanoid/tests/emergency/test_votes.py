"""Whose word stops the robot, and whose word releases it."""

from __future__ import annotations

from humanoid.emergency.votes import GONE, MISSED, Publisher, StopVotes

SWITCH = Publisher(b'switch', '/joint_state_service', is_switch=True)
NEXT_SWITCH = SWITCH._replace(gid=b'next switch')
STRANGER = Publisher(b'stranger', '/bag', is_switch=False)
ONE_OF_SEVERAL = Publisher(b'', 'one of /bag, /joint_state_service', is_switch=False)
ALL = (SWITCH.gid, NEXT_SWITCH.gid, STRANGER.gid)


def votes_of(*words: tuple[Publisher, bool]) -> StopVotes:
    votes = StopVotes()
    for publisher, stopped in words:
        votes.hear(publisher, stopped=stopped)
    return votes


def fall_silent(votes: StopVotes) -> bool:
    return any(votes.look(ALL) for _ in range(MISSED + 1))


def test_a_switch_takes_its_own_stop_back() -> None:
    votes = votes_of((SWITCH, True))
    assert votes.stopped_by == SWITCH
    assert not votes.hear(SWITCH, stopped=False)
    assert not votes.stopped


def test_nobody_takes_back_what_another_has_said() -> None:
    for stopper, other in ((SWITCH, STRANGER), (STRANGER, SWITCH), (SWITCH, NEXT_SWITCH)):
        votes = votes_of((stopper, True), (other, False))
        assert votes.stopped_by == stopper


def test_a_stranger_takes_its_own_stop_back() -> None:
    assert not votes_of((SWITCH, False), (STRANGER, True), (STRANGER, False)).stopped


def test_one_of_several_publishers_that_cannot_be_told_apart_releases_nothing() -> None:
    votes = votes_of((ONE_OF_SEVERAL, True), (ONE_OF_SEVERAL, False))
    assert votes.stopped
    assert fall_silent(votes)
    assert votes.stopped, 'whoever said so is gone'


def test_a_stranger_that_says_released_is_no_switch() -> None:
    votes = votes_of((STRANGER, False))
    assert not votes.knows_switch
    assert not fall_silent(votes)
    assert not votes.stopped


def test_a_switch_that_falls_silent_stops_the_robot_however_loud_a_stranger_is() -> None:
    votes = votes_of((SWITCH, False))
    for _ in range(MISSED):
        assert not votes.look(ALL)
        votes.hear(STRANGER, stopped=False)
    assert votes.look(ALL)
    assert votes.lost == GONE
    votes.hear(STRANGER, stopped=False)
    assert votes.stopped


def test_a_stranger_that_has_stopped_the_robot_may_be_silent_but_not_leave() -> None:
    votes = votes_of((STRANGER, True))
    assert not fall_silent(votes)
    assert votes.stopped_by == STRANGER
    assert votes.look([SWITCH.gid])
    assert votes.lost == '/bag, which had stopped it, is gone.'


def test_after_a_loss_a_switch_has_to_be_thrown_and_released() -> None:
    votes = votes_of((SWITCH, False))
    fall_silent(votes)
    assert votes.hear(NEXT_SWITCH, stopped=False), 'it is to be thrown'
    assert votes.hear(NEXT_SWITCH, stopped=False), 'again, until it says so'
    votes.hear(STRANGER, stopped=True)
    votes.hear(STRANGER, stopped=False)
    assert votes.stopped, 'a recording of a stop and a release does not count'
    assert not votes.hear(NEXT_SWITCH, stopped=True)
    assert not votes.hear(NEXT_SWITCH, stopped=False)
    assert not votes.stopped


def test_a_switch_that_is_started_while_the_robot_is_stopped_is_thrown_once() -> None:
    votes = votes_of((SWITCH, True))
    assert votes.hear(NEXT_SWITCH, stopped=False)
    assert not votes.hear(NEXT_SWITCH, stopped=True)
    assert not votes.hear(SWITCH, stopped=False)
    assert votes.stopped_by == NEXT_SWITCH
    assert not votes.hear(NEXT_SWITCH, stopped=False), 'both were released'
    assert not votes.stopped


def test_of_several_that_stop_the_robot_the_stranger_is_named() -> None:
    assert votes_of((SWITCH, True), (STRANGER, True)).stopped_by == STRANGER
