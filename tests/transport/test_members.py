"""What is declared at a place leaves with it, and nothing comes after."""

from __future__ import annotations

import pytest

from goalwire.errors import ClosedError
from goalwire.transport.fork import ForkGuard
from goalwire.transport.members import Members
from goalwire.transport.place import Place


class Thing:
    """Something declared, which leaves its place as endpoints do."""

    def __init__(self, members: Members, gid: bytes) -> None:
        self.gid = gid
        self.place = Place(f'thing {gid!r}', ForkGuard(), lambda: members.forget(gid))

    def close(self) -> None:
        self.place.give_up()


def home() -> tuple[Place, Members]:
    """Return a place whose members leave with it."""

    def leave() -> None:
        members.close()

    place = Place('home', ForkGuard(), leave)
    members = Members(place)
    return place, members


def test_all_members_are_closed_with_their_place() -> None:
    place, members = home()
    things = [members.keep(Thing(members, bytes([number]))) for number in range(3)]
    things[1].close()
    place.give_up()
    assert [thing.place.closed for thing in things] == [True] * 3
    assert members._members == {}


def test_who_comes_after_the_end_is_closed_and_told() -> None:
    place, members = home()
    place.give_up()
    late = Thing(members, b'late')
    with pytest.raises(ClosedError, match='home was used after'):
        members.keep(late)
    assert late.place.closed
    assert members._members == {}


def test_forgetting_an_unknown_one_is_harmless() -> None:
    place, members = home()
    thing = members.keep(Thing(members, b'known'))
    members.forget(b'never seen')
    assert list(members._members.values()) == [thing]
    place.give_up()
    assert thing.place.closed
