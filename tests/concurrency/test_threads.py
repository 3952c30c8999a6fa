"""Threads whose start a signal's handler may interrupt."""

from __future__ import annotations

import signal
import sys
import threading

import pytest
from helpers.patience import PATIENCE, soon

from goalwire.concurrency.threads import begin, join_begun
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.time.timer_heap import TimerThread


def test_a_thread_that_has_begun_is_waited_for() -> None:
    ended = threading.Event()
    thread = threading.Thread(target=ended.set)
    thread.start()
    assert join_begun(thread)
    assert ended.is_set()


def test_one_that_never_began_is_not_waited_for() -> None:
    assert not join_begun(threading.Thread(target=print))


@pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')
def test_a_thread_begins_although_a_handler_raises_meanwhile() -> None:
    class Late(Exception):
        pass

    class Interrupted(threading.Thread):
        """Has the main thread run its handler before the start goes on."""

        def start(self) -> None:
            signal.pthread_kill(main, signal.SIGALRM)
            assert soon(rang)
            super().start()

    def ring(*_: object) -> None:
        rang.set()
        raise Late

    main, rang, ran = threading.get_ident(), threading.Event(), threading.Event()
    thread = Interrupted(target=ran.set)
    before = signal.signal(signal.SIGALRM, ring)
    try:
        with pytest.raises(Late):
            begin(thread)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert soon(ran)
    thread.join(PATIENCE)


def test_a_thread_that_python_refuses_is_an_error_of_its_beginning(monkeypatch: pytest.MonkeyPatch) -> None:
    thread = threading.Thread(target=print)
    monkeypatch.setattr(thread, 'start', refuse)
    with pytest.raises(RuntimeError, match='no further thread'):
        begin(thread)


def refuse() -> None:
    """Do as `Thread.start` does if the system has no room for another thread."""
    raise RuntimeError('no further thread')


def test_timers_end_although_ctrl_c_came_as_their_thread_was_started(monkeypatch: pytest.MonkeyPatch) -> None:
    def start(thread: threading.Thread) -> None:
        raise KeyboardInterrupt

    shutdown_signal = ShutdownSignal()
    timers = TimerThread(shutdown_signal, 'timers')
    listener = Listener()
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, 'start', start)
        with pytest.raises(KeyboardInterrupt):
            timers.tell_end(listener)
    shutdown_signal.end('over')
    timers.close()
    assert listener.has_ended


class Listener:
    """Is told of the end."""

    has_ended = False

    def end(self) -> None:
        self.has_ended = True
