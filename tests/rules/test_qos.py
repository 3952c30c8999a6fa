"""The policies of a QoS profile, and the profile that goes together with others."""

from __future__ import annotations

import pytest

from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy, suiting

RELIABLE = QoS(depth=1, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoS(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LOSSY = QoS(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


@pytest.mark.parametrize(
    ('offered', 'reliable', 'latched'),
    [
        ([], False, False),
        ([RELIABLE], True, False),
        ([LATCHED, LATCHED], True, True),
        ([LATCHED, RELIABLE], True, False),
        ([LATCHED, LOSSY], False, False),
    ],
    ids=['nobody', 'reliable', 'all latched', 'one latched', 'one lossy'],
)
def test_a_subscription_asks_for_what_every_publisher_offers(
    offered: list[QoS], reliable: bool, latched: bool
) -> None:
    wanted = suiting(offered, 7)
    assert wanted.depth == 7
    assert wanted.is_transient_local is latched
    assert (wanted.reliability is ReliabilityPolicy.RELIABLE) is reliable
