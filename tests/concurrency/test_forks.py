"""Things that were opened before a fork, and things that a child resets."""

from __future__ import annotations

import os
import sys
from types import FrameType

import pytest
from helpers.processes import Program

from goalwire.concurrency.forks import ForkGuard, open_privately, reset_in_children
from goalwire.errors import ForkedError
from goalwire.transport.endpoint import close_at_exit

FORKING = """
    import os
    from goalwire.concurrency.forks import ForkGuard, in_child

    calls = []
    in_child(lambda: calls.append(os.getpid()))
    before = ForkGuard()
    if os.fork() == 0:
        after = ForkGuard()
        os._exit(0 if before.is_forked and not after.is_forked and calls == [os.getpid()] else 1)
    code = os.waitstatus_to_exitcode(os.wait()[1])
    print('child', code, 'parent', before.is_forked, calls)
"""


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='this system has no fork')
def test_only_the_child_and_only_what_was_opened_before_is_forked() -> None:
    with Program(FORKING) as program:
        assert program.succeed() == 'child 0 parent False []'


FAILING = """
    import os
    from goalwire.concurrency.forks import in_child, reset_in_children

    class Thing:
        def reset_in_child(self):
            done.append('thing')

    def fail():
        raise OSError('first')

    done = []
    thing = Thing()
    in_child(fail)
    in_child(lambda: done.append('second'))
    reset_in_children(thing)
    if os.fork() == 0:
        print('child', sorted(done), flush=True)
        os._exit(0)
    os.wait()
"""


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='this system has no fork')
def test_a_reset_that_fails_is_told_and_the_others_are_done() -> None:
    with Program(FAILING) as program:
        output = program.succeed()
    assert "child ['second', 'thing']" in output
    assert 'OSError: first' in output


OPENING = """
    import os
    import socket
    import threading
    from goalwire.concurrency.forks import open_privately

    opened, forking = threading.Event(), threading.Event()
    sockets = []

    def open_it():
        sockets.append(socket.socket())
        opened.set()
        forking.wait()
        return sockets[0]

    opener = threading.Thread(target=open_privately, args=(open_it,))
    opener.start()
    opened.wait()
    os.register_at_fork(before=forking.set)  # of such functions the last one is called first
    if os.fork() == 0:
        os._exit(0 if sockets[0].fileno() < 0 else 1)
    code = os.waitstatus_to_exitcode(os.wait()[1])
    opener.join()
    print('child', code, 'parent', sockets[0].fileno() >= 0)
"""


@pytest.mark.skipif(not hasattr(os, 'fork'), reason='this system has no fork')
def test_a_socket_that_another_thread_is_opening_is_closed_in_the_child_alone() -> None:
    with Program(OPENING) as program:
        assert program.succeed() == 'child 0 parent True'


def test_no_step_of_python_runs_when_something_dies_that_forks_know() -> None:
    """A signal's handler can raise in such a step. Python would print the KeyboardInterrupt and lose it."""

    class Thing:
        def close(self) -> None:
            """Close nothing."""

        def reset_in_child(self) -> None:
            """Reset nothing."""

    entered: list[str] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == 'call':
            entered.append(frame.f_code.co_qualname)

    thing, guard = open_privately(Thing), ForkGuard()
    reset_in_children(thing)
    close_at_exit(thing)
    before = sys.getprofile()
    sys.setprofile(note)
    del thing, guard
    sys.setprofile(before)
    assert entered == []


def test_a_guard_lets_its_own_process_pass() -> None:
    ForkGuard().check('session')


def test_the_refusal_names_the_thing_and_the_way_out() -> None:
    guard = ForkGuard()
    guard.is_forked = True
    with pytest.raises(
        ForkedError, match=r'^publisher /chatter was opened before .* new context in the child'
    ):
        guard.check('publisher /chatter')
