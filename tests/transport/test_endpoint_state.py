"""Giving a place on the wire up, by several threads at once."""

from __future__ import annotations

import threading

from helpers.patience import PATIENCE

from goalwire.transport.endpoint_state import EndpointState
from goalwire.transport.fork import ForkGuard


class Leaving:
    """A place whose undeclaring takes as long as a test wants."""

    def __init__(self) -> None:
        self.begun = threading.Event()
        self.may_end = threading.Event()
        self.times = 0
        self.state = EndpointState('a thing', ForkGuard(), self._leave)

    def _leave(self) -> None:
        self.times += 1
        self.begun.set()
        assert self.may_end.wait(PATIENCE)


def test_a_second_close_returns_after_the_first_has_ended() -> None:
    leaving, second_is_back = Leaving(), threading.Event()

    def close_too() -> None:
        leaving.state.close()
        second_is_back.set()

    threads = [threading.Thread(target=leaving.state.close), threading.Thread(target=close_too)]
    threads[0].start()
    assert leaving.begun.wait(PATIENCE)
    threads[1].start()
    assert not second_is_back.wait(0.1)
    leaving.may_end.set()
    assert second_is_back.wait(PATIENCE)
    for thread in threads:
        thread.join()
    assert leaving.times == 1


def test_closing_within_the_closing_returns_at_once() -> None:
    calls: list[bool] = []

    def leave() -> None:
        state.close()
        calls.append(state.closed)

    state = EndpointState('a thing', ForkGuard(), leave)
    state.close()
    assert calls == [True]
