"""Code that is interrupted on its own thread: one at a time, in order, and no lock is left taken."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

import pytest
from helpers.interrupting import at_each_call
from helpers.patience import PATIENCE
from helpers.zenoh_protocol import pair

from goalwire.concurrency.critical_section import CriticalSection
from goalwire.zenoh.protocol.publication import Publication


def is_free(section: CriticalSection) -> bool:
    """Whether another thread gets in."""
    got: list[bool] = []
    thread = threading.Thread(target=lambda: got.append(section.run(bool)))
    thread.start()
    thread.join(PATIENCE)
    return got == [True]


def interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def put_and_interrupt(put: Callable[[bytes], None]) -> None:
    put(b'2')
    raise KeyboardInterrupt


def test_what_interrupts_is_done_after_it_in_order() -> None:
    section, done = CriticalSection(), list[str]()

    def outer() -> None:
        assert section.is_entered()
        for name in ('second', 'third'):
            assert not section.run(partial(inner, name))
        done.append('first')

    def inner(name: str) -> None:
        done.append(name)
        if name == 'second':
            section.run(partial(done.append, 'fourth'))

    assert section.run(outer)
    assert done == ['first', 'second', 'third', 'fourth']
    assert not section.is_entered()
    assert is_free(section)


def test_one_that_raises_leaves_it_to_others_and_what_waited_is_done() -> None:
    section, done = CriticalSection(), list[str]()

    def outer() -> None:
        section.run(partial(done.append, 'late'))
        raise ValueError('no')

    with pytest.raises(ValueError, match='no'):
        section.run(outer)
    assert done == ['late']
    assert is_free(section)


def test_what_is_done_late_may_raise() -> None:
    section, done = CriticalSection(), list[str]()

    def outer() -> None:
        section.run(interrupt)
        section.run(partial(done.append, 'late'))

    with pytest.raises(KeyboardInterrupt):
        section.run(outer)
    assert is_free(section)
    section.run(bool)
    assert done == ['late']


@pytest.mark.parametrize('handler', [interrupt, put_and_interrupt])
def test_a_handler_that_raises_leaves_no_link_locked(
    handler: Callable[[Callable[[bytes], None]], None],
) -> None:
    for interruption in at_each_call():
        one, _, cable = pair()
        first, second = Publication(one, 'a'), Publication(one, 'b')
        try:
            interruption.run(partial(first.put, b'1'), partial(handler, second.put))
        except KeyboardInterrupt:
            assert interruption.place
        assert is_free(cable.links[0].outgoing.section), interruption.place
        assert is_free(one.section), interruption.place


def test_who_interrupts_the_way_out_comes_after_what_waits() -> None:
    done: list[str] = []

    class Interrupted(CriticalSection):
        """A signal's handler comes just before what was left for later is done."""

        interrupts = True

        def run_late(self) -> None:
            if self.interrupts:
                self.interrupts = False
                self.run(lambda: done.append('second handler'))
            super().run_late()

    section = Interrupted()

    def work() -> None:
        section.run(lambda: done.append('first handler'))
        done.append('work')

    section.run(work)
    assert done == ['work', 'first handler', 'second handler']
