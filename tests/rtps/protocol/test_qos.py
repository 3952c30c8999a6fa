"""Which writers and readers match."""

from __future__ import annotations

import pytest

from goalwire.records import replace
from goalwire.rtps.protocol.qos import (
    BEST_EFFORT,
    EXCLUSIVE,
    MANUAL_BY_TOPIC,
    READER_DEFAULT,
    RELIABLE,
    TRANSIENT_LOCAL,
    WRITER_DEFAULT,
    Qos,
    incompatible,
    read_qos,
    share_partition,
    write_qos,
)

FULL = Qos(
    reliability=RELIABLE,
    max_blocking=10**9,
    durability=TRANSIENT_LOCAL,
    depth=0,
    deadline=2 * 10**9,
    lifespan=3 * 10**9,
    liveliness=MANUAL_BY_TOPIC,
    lease=4 * 10**9,
    ownership=EXCLUSIVE,
    partition=('a', 'b/*'),
    representation=(2, 0),
)


@pytest.mark.parametrize('qos', [FULL, WRITER_DEFAULT, READER_DEFAULT, replace(FULL, depth=7)])
def test_what_is_written_is_read(qos: Qos) -> None:
    assert read_qos(write_qos(qos), 1, WRITER_DEFAULT) == qos


def test_what_is_not_told_is_the_default_of_that_end() -> None:
    assert read_qos([], 1, WRITER_DEFAULT).reliability == RELIABLE
    assert read_qos([], 1, READER_DEFAULT).reliability == BEST_EFFORT


@pytest.mark.parametrize(
    ('offered', 'requested', 'policy'),
    [
        (WRITER_DEFAULT, READER_DEFAULT, None),
        (WRITER_DEFAULT, Qos(reliability=RELIABLE), None),
        (Qos(), Qos(reliability=RELIABLE), 'reliability'),
        (WRITER_DEFAULT, Qos(durability=TRANSIENT_LOCAL), 'durability'),
        (WRITER_DEFAULT, Qos(deadline=1), 'deadline'),
        (Qos(deadline=5), Qos(deadline=5), None),
        (Qos(deadline=6), Qos(deadline=5), 'deadline'),
        (Qos(lease=6), Qos(lease=5), 'liveliness'),
        (Qos(), Qos(liveliness=MANUAL_BY_TOPIC), 'liveliness'),
        (Qos(ownership=EXCLUSIVE), Qos(), 'ownership'),
        (Qos(representation=(2,)), Qos(), 'data representation'),
        (Qos(representation=(0, 2)), Qos(), None),
        (Qos(lifespan=1), Qos(), None),
    ],
)
def test_the_first_policy_that_does_not_fit_is_named(
    offered: Qos, requested: Qos, policy: str | None
) -> None:
    assert incompatible(offered, requested) == policy


@pytest.mark.parametrize(
    ('offered', 'requested', 'shared'),
    [
        ((), (), True),
        (('a',), (), False),
        (('',), (), True),
        (('a', 'b'), ('c', 'b'), True),
        (('a*',), ('abc',), True),
        (('abc',), ('a?c',), True),
        (('a*',), ('a*',), True),
        (('a*',), ('ab*',), False),
    ],
)
def test_partitions(offered: tuple[str, ...], requested: tuple[str, ...], shared: bool) -> None:
    assert share_partition(offered, requested) is shared
