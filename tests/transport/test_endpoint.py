"""The life of what is declared on a wire: opening, children, closing, and what several users share."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest
from helpers.patience import PATIENCE
from helpers.processes import Program

from goalwire.concurrency.forks import ForkGuard
from goalwire.errors import ClosedError
from goalwire.transport.endpoint import Children, EndpointState, Shared


class Thing:
    """Something declared."""

    def __init__(self, state: EndpointState, gid: bytes = b'thing') -> None:
        self.state = state
        self.gid = gid


class WatchedLock:
    """A lock of an endpoint that tells when somebody has to wait for it."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self.waited_for = threading.Event()

    def acquire(self, timeout: float) -> bool:
        """Take it; the event is set before a wait."""
        if self._lock.acquire(blocking=False):
            return True
        self.waited_for.set()
        return self._lock.acquire(timeout=timeout)

    def release(self) -> None:
        """Give it back."""
        self._lock.release()


def family() -> tuple[EndpointState, Children]:
    """Return a parent whose children close with it."""
    state = EndpointState('home', ForkGuard())
    children = Children(state)
    state.undo.append(children.close)
    return state, children


def opened(children: Children, gid: bytes, *undo: Callable[[], object]) -> Thing:
    """Open a child."""
    with children.opening(f'thing {gid!r}') as state:
        state.undo += undo
        return children.keep(Thing(state, gid))


# -- closing


def test_closing_undoes_each_step_once_and_the_last_first() -> None:
    done: list[int] = []
    state = EndpointState('a thing', ForkGuard())
    state.undo += [lambda: done.append(1), lambda: done.append(2)]
    state.close()
    state.close()
    assert done == [2, 1]


def test_a_step_that_fails_holds_up_none_of_the_others_and_is_told() -> None:
    done: list[int] = []

    def fail(why: str) -> None:
        raise ValueError(why)

    state = EndpointState('a thing', ForkGuard())
    state.undo += [lambda: done.append(1), lambda: fail('second'), lambda: fail('first')]
    with pytest.raises(ValueError, match='first'):
        state.close()
    assert done == [1]


def test_a_second_close_returns_after_the_first_has_ended() -> None:
    begun, may_end, second_is_back = threading.Event(), threading.Event(), threading.Event()
    times: list[bool] = []

    def leave() -> None:
        begun.set()
        times.append(may_end.wait(PATIENCE))

    def close_too() -> None:
        state.close()
        second_is_back.set()

    state = EndpointState('a thing', ForkGuard())
    state.undo.append(leave)
    threads = [threading.Thread(target=state.close), threading.Thread(target=close_too)]
    turn = state._turn = WatchedLock()  # type: ignore[assignment]
    threads[0].start()
    assert begun.wait(PATIENCE)
    threads[1].start()
    assert turn.waited_for.wait(PATIENCE)
    assert not second_is_back.is_set()
    may_end.set()
    assert second_is_back.wait(PATIENCE)
    for thread in threads:
        thread.join()
    assert times == [True]


def test_closing_within_the_closing_returns_at_once() -> None:
    calls: list[bool] = []

    def leave() -> None:
        state.close()
        calls.append(state.closed)

    state = EndpointState('a thing', ForkGuard())
    state.undo.append(leave)
    state.close()
    assert calls == [True]


# -- children


def test_all_children_are_closed_with_their_parent() -> None:
    state, children = family()
    things = [opened(children, bytes([number])) for number in range(3)]
    things[1].state.close()
    state.close()
    assert [thing.state.closed for thing in things] == [True] * 3
    assert children._children == {}


def test_what_was_done_for_a_child_that_cannot_be_opened_is_undone() -> None:
    _, children = family()
    done: list[str] = []

    def fail(undo: list[Callable[[], object]]) -> None:
        undo.append(lambda: done.append('undone'))
        raise ValueError('halfway')

    with pytest.raises(ValueError, match='halfway'), children.opening('thing') as state:
        fail(state.undo)
    assert (state.closed, done) == (True, ['undone'])


def test_who_comes_after_the_end_of_the_parent_is_undone_and_told() -> None:
    parent, children = family()
    done: list[str] = []

    def close_and_keep(state: EndpointState) -> None:
        state.undo.append(lambda: done.append('undone'))
        parent.close()
        children.keep(Thing(state))

    with pytest.raises(ClosedError, match='home was used after'), children.opening('thing') as state:
        close_and_keep(state)
    assert (state.closed, done, children._children) == (True, ['undone'], {})
    with pytest.raises(ClosedError, match='home was used after'), children.opening('another'):
        pytest.fail('it was opened')


def test_a_failure_that_the_end_of_the_parent_has_caused_is_told_as_that() -> None:
    parent, children = family()

    def fail() -> None:
        parent.close()
        raise ValueError('the wire is gone')

    with pytest.raises(ClosedError, match='home was used after'), children.opening('thing'):
        fail()


def test_who_closes_the_parent_waits_for_a_child_that_is_just_closing() -> None:
    parent, children = family()
    begun, may_end, parent_is_closed = threading.Event(), threading.Event(), threading.Event()
    waited: list[bool] = []

    def leave() -> None:
        begun.set()
        waited.append(may_end.wait(PATIENCE))

    def close_parent() -> None:
        parent.close()
        parent_is_closed.set()

    thing = opened(children, b'slow', leave)
    threads = [threading.Thread(target=thing.state.close), threading.Thread(target=close_parent)]
    turn = thing.state._turn = WatchedLock()  # type: ignore[assignment]
    threads[0].start()
    assert begun.wait(PATIENCE)
    threads[1].start()
    assert turn.waited_for.wait(PATIENCE)
    assert not parent_is_closed.is_set()
    may_end.set()
    assert parent_is_closed.wait(PATIENCE)
    for thread in threads:
        thread.join()
    assert waited == [True]


def test_discarding_an_unknown_one_is_harmless() -> None:
    state, children = family()
    thing = opened(children, b'known')
    children.discard(b'never seen')
    assert list(children._children.values()) == [thing]
    state.close()
    assert thing.state.closed


# -- the end of the interpreter

ENDING = """
    from goalwire.concurrency.exits import Stage, at_exit
    from goalwire.transport.endpoint import close_at_exit

    class Session:
        def close(self):
            print('closed')

    at_exit(Stage.LIBRARIES, lambda: print('afterwards'))
    session = Session()
    close_at_exit(session)
    print('ends')
"""


def test_what_is_open_at_the_end_is_closed_and_then_the_last_steps_follow() -> None:
    with Program(ENDING) as program:
        assert program.succeed().split() == ['ends', 'closed', 'afterwards']


# -- what several users share


def test_a_shared_thing_is_made_for_its_first_user_and_ends_with_its_last() -> None:
    ended: list[object] = []
    shared: Shared[int, object] = Shared(ended.append)
    thing = shared.open(7, object)
    assert shared.open(7, object) is thing
    other = shared.open(8, object)
    assert other is not thing
    shared.close(8)
    shared.close(7)
    assert (ended, shared.get(7), shared.users()) == ([other], thing, 1)
    shared.close(7)
    shared.close(7)
    assert (ended, shared.get(7), shared.users()) == ([other, thing], None, 0)


def test_what_cannot_be_made_has_no_user() -> None:
    shared: Shared[int, object] = Shared()

    def fail() -> object:
        raise OSError('no room')

    with pytest.raises(OSError, match='no room'):
        shared.open(7, fail)
    assert shared.users() == 0
    assert shared.open(7, object) is shared.get(7)


def test_all_that_is_shared_ends_whoever_uses_it() -> None:
    ended: list[str] = []
    shared: Shared[int, str] = Shared(ended.append)
    shared.open(7, lambda: 'seven')
    shared.open(7, lambda: 'never')
    shared.close_all()
    shared.close(7)
    assert (ended, shared.users()) == (['seven'], 0)
