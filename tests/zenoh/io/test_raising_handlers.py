"""A signal's handler raises while its thread writes: the link stays, and nothing arrives in part."""

from __future__ import annotations

import itertools
import signal
import threading
from collections.abc import Iterator

import pytest
from helpers.patience import wait_for
from helpers.zenoh_sides import Ours, address

TIMES = 150


class RaisedError(BaseException):
    """The exception that the handler raises; like KeyboardInterrupt, it is not an exception of a callback."""


@pytest.fixture
def raised() -> Iterator[None]:
    """Have SIGUSR1 raise."""

    def handler(*_: object) -> None:
        raise RaisedError

    before = signal.signal(signal.SIGUSR1, handler)
    yield
    signal.signal(signal.SIGUSR1, before)


def put_for_ever(side: Ours, size: int, killer: threading.Timer) -> None:
    killer.start()
    for number in itertools.count():
        side.put('a', bytes((number % 251,)) * size)


@pytest.mark.parametrize('size', [100, 300_000], ids=['small', 'in pieces'])
def test_messages_are_whole_and_the_link_stays_whenever_a_handler_raises(raised: None, size: int) -> None:
    one = Ours('peer', listen=(address(),))
    other = Ours('peer', connect=(one.protocol.gossip.locators[0],))
    heard = other.subscribe('a')
    last = other.subscribe('last')
    wait_for(lambda: (one.put('last', b''), last.samples)[1], 'the link')  # type: ignore[func-returns-value]
    (link,) = one.protocol.links
    main = threading.main_thread().ident
    assert main is not None
    for number in range(TIMES):
        killer = threading.Timer(0.0005 + number * 2e-5, signal.pthread_kill, (main, signal.SIGUSR1))
        with pytest.raises(RaisedError):
            put_for_ever(one, size, killer)
        killer.join()
    one.put('last', b'end')
    wait_for(lambda: last.samples[-1] == ('last', b'end'), 'the last message')
    assert one.protocol.links == (link,)
    assert all(payload and payload == payload[:1] * size for _, payload in heard.samples)
    one.close()
    other.close()
