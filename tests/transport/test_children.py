"""What is declared at a place leaves with it, and nothing comes after."""

from __future__ import annotations

import pytest

from goalwire.errors import ClosedError
from goalwire.transport.children import Children
from goalwire.transport.endpoint_state import EndpointState
from goalwire.transport.fork import ForkGuard


class Thing:
    """Something declared, which leaves its place as endpoints do."""

    def __init__(self, children: Children, gid: bytes) -> None:
        self.gid = gid
        self.state = EndpointState(f'thing {gid!r}', ForkGuard(), lambda: children.forget(gid))

    def close(self) -> None:
        self.state.close()


def work_queue() -> tuple[EndpointState, Children]:
    """Return a place whose members leave with it."""

    def leave() -> None:
        children.close()

    state = EndpointState('home', ForkGuard(), leave)
    children = Children(state)
    return state, children


def test_all_members_are_closed_with_their_place() -> None:
    state, children = work_queue()
    things = [children.keep(Thing(children, bytes([number]))) for number in range(3)]
    things[1].close()
    state.close()
    assert [thing.state.closed for thing in things] == [True] * 3
    assert children._children == {}


def test_who_comes_after_the_end_is_closed_and_told() -> None:
    state, children = work_queue()
    state.close()
    late = Thing(children, b'late')
    with pytest.raises(ClosedError, match='home was used after'):
        children.keep(late)
    assert late.state.closed
    assert children._children == {}


def test_forgetting_an_unknown_one_is_harmless() -> None:
    state, children = work_queue()
    thing = children.keep(Thing(children, b'known'))
    children.forget(b'never seen')
    assert list(children._children.values()) == [thing]
    state.close()
    assert thing.state.closed
