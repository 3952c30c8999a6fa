"""A link may end in one thread, or in a signal's handler, while another reads or negotiates."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest
from helpers.zenoh_memory import segments_of

from goalwire.zenoh.io.shared_memory.agreement import Agreement, OwnAuth, Partner, read_partner
from goalwire.zenoh.io.shared_memory.pool import MemoryPool
from goalwire.zenoh.io.shared_memory.reader import MemoryReader
from goalwire.zenoh.io.shared_memory.segments import ForeignSegment, path_of
from goalwire.zenoh.io.shared_memory.session_memory import LinkMemory
from goalwire.zenoh.protocol.primitives import ZenohProtocolError
from goalwire.zenoh.protocol.shared_memory import Pointer, Slices


@pytest.fixture
def auth() -> Iterator[OwnAuth]:
    """A session's segment for the handshake."""
    own = OwnAuth(os.urandom, reads_all=False)
    yield own
    own.segment.close()


def no_memory(*_: object) -> LinkMemory:
    raise AssertionError('this link has ended')


def test_a_handshake_that_ends_as_it_opens_a_segment_keeps_it_not(auth: OwnAuth) -> None:
    before = sorted(os.listdir('/proc/self/fd'))  # noqa: PTH208

    def end_it(_: Partner) -> bool:
        agreement.close()
        return True

    agreement = Agreement(auth, end_it, no_memory)
    assert agreement.answer(agreement.offer()) is None
    assert agreement.make_memory(lambda _: None) is None
    assert sorted(os.listdir('/proc/self/fd')) == before  # noqa: PTH208


class EndsMeanwhile(list['bytes | Pointer']):
    """The slices of a message; the link ends as they are read."""

    def __init__(self, slices: Slices, end: Callable[[], object]) -> None:
        super().__init__(slices)
        self._end = end
        self._rounds = 0

    def __iter__(self) -> Iterator[bytes | Pointer]:
        self._rounds += 1
        if self._rounds == 2:  # the first round adds the sizes
            self._end()
        return super().__iter__()


def test_a_link_that_ends_within_a_read_keeps_no_segment_open(auth: OwnAuth) -> None:
    pool = MemoryPool(1 << 20, 1024, auth.number, print)
    chunk = pool.borrow(5000)
    assert chunk is not None
    writers = pool.add_reader(ForeignSegment(auth.number, writable=True))
    pointer = pool.lend(chunk, writers)
    assert pointer is not None
    before = segments_of(os.getpid())
    partner = read_partner(auth.number)
    memory = LinkMemory(
        partner,
        lambda: None,
        lambda: MemoryReader(partner, (), None, None, lambda: False, 1 << 20, lambda _: None),
    )
    slices = EndsMeanwhile([pointer], memory.close)
    with suppress(ZenohProtocolError):  # either the message comes whole, or the ended link refuses it
        assert len(memory.take(slices, 0, as_view=False) or b'') == 5000
    assert memory.take([pointer], 0, as_view=False) is None
    assert segments_of(os.getpid()) == before
    pool.close()


def test_a_segment_that_nobody_closes_is_closed_as_it_is_dropped(auth: OwnAuth) -> None:
    segment = ForeignSegment(auth.number)
    fd = segment.fd
    assert os.readlink(f'/proc/self/fd/{fd}') == path_of(auth.number)  # noqa: PTH115
    del segment
    gc.collect()
    with pytest.raises(OSError, match='Bad file'):
        os.fstat(fd)


def test_a_closed_segment_has_no_mapping(auth: OwnAuth) -> None:
    segment = ForeignSegment(auth.number)
    segment.close()
    segment.close()
    with pytest.raises(ValueError, match='is closed'):
        _ = segment.map
