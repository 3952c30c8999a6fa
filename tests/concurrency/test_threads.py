"""Threads whose start a signal's handler may interrupt."""

from __future__ import annotations

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


def test_a_handler_that_raises_as_a_thread_has_begun_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    class Late(Exception):
        pass

    def start_as_python(*arguments: object, **options: object) -> None:
        """Start the thread; once it has ended, raise as a handler does."""
        real_start(*arguments, **options)
        assert soon(ended)
        thread.join(PATIENCE)
        raise Late

    name = '_start_joinable_thread' if hasattr(threading, '_start_joinable_thread') else '_start_new_thread'
    real_start = getattr(threading, name)
    ended = threading.Event()
    thread = threading.Thread(target=ended.set)
    monkeypatch.setattr(threading, name, start_as_python)
    with pytest.raises(Late):
        begin(thread)


def test_a_handlers_own_key_error_stays_also_while_another_error_is_handled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def start() -> None:
        raise KeyError('mine')

    thread = threading.Thread(target=print)
    monkeypatch.setattr(thread, 'start', start)
    try:
        raise ValueError('another')  # noqa: TRY301 - it is being handled, as in a program
    except ValueError:
        with pytest.raises(KeyError, match='mine'):
            begin(thread)


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
