"""Giving a place on the wire up, by several threads at once."""

from __future__ import annotations

import threading

from goalwire.transport.fork import ForkGuard
from goalwire.transport.place import Place

PATIENCE = 10.0


class Leaving:
    """A place whose undeclaring takes as long as a test wants."""

    def __init__(self) -> None:
        self.begun = threading.Event()
        self.may_end = threading.Event()
        self.times = 0
        self.place = Place('a thing', ForkGuard(), self._leave)

    def _leave(self) -> None:
        self.times += 1
        self.begun.set()
        assert self.may_end.wait(PATIENCE)


def test_a_second_close_returns_after_the_first_has_ended() -> None:
    leaving, second_is_back = Leaving(), threading.Event()

    def close_too() -> None:
        leaving.place.give_up()
        second_is_back.set()

    threads = [threading.Thread(target=leaving.place.give_up), threading.Thread(target=close_too)]
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
        place.give_up()
        calls.append(place.closed)

    place = Place('a thing', ForkGuard(), leave)
    place.give_up()
    assert calls == [True]
