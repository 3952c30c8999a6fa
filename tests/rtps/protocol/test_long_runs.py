"""A million samples through simulated networks, of all kinds and sizes."""

from __future__ import annotations

from random import Random

import pytest
from helpers.rtps_network import Collector, Network, Publisher

from goalwire.rtps.protocol.qos import RELIABLE, TRANSIENT_LOCAL, Qos


def _run(seed: int, samples: int) -> None:
    """Send samples of mixed sizes from two writers to three readers, over a network that loses up to 30 %."""
    random = Random(seed)
    network = Network(
        seed,
        loss=random.choice([0, 0.01, 0.1, 0.3]),
        double=random.choice([0, 0.1, 0.3]),
        delay_s=random.choice([0, 0.001, 0.03]),
    )
    durability = random.choice([0, 0, TRANSIENT_LOCAL])
    qos = Qos(reliability=RELIABLE, durability=durability, depth=0)
    sides = [network.participant(same_host=random.random() < 0.5)[0] for _ in range(3)]
    publishers = [Publisher() for _ in range(2)]
    writers = [sides[at].create_writer('t', 'T', qos, publishers[at]) for at in range(2)]
    collectors = [Collector() for _ in sides]
    for side, collector in zip(sides, collectors, strict=True):
        side.create_reader('t', 'T', qos, collector)
    assert network.run(60, lambda: all(len(one.matched) == 3 for one in publishers))
    assert network.run(60, lambda: all(len(one.matched) == 2 for one in collectors))
    sent: list[list[bytes]] = [[], []]
    while len(sent[0]) + len(sent[1]) < samples:
        at = random.randrange(2)
        size = random.choice([0] * 40 + [100] * 20 + [9_000, 70_000])
        payload = b'\0\1\0\0' + len(sent[at]).to_bytes(4, 'little') + bytes(size)
        if writers[at].write(payload) is None:
            network.run(0.01)
        else:
            sent[at].append(payload)
            if random.random() < 0.2:
                network.run(random.choice([0, 0.0005, 0.01]))
    total = len(sent[0]) + len(sent[1])
    assert network.run(600, lambda: all(len(one.samples) == total for one in collectors)), (
        seed,
        vars(network),
    )
    for collector in collectors:
        assert collector.lost == 0
        for at in range(2):
            guid = writers[at].data.guid
            assert [one.payload for one in collector.samples if one.writer == guid] == sent[at], seed


@pytest.mark.parametrize('seed', range(4))
def test_reliable_means_all_in_order(seed: int) -> None:
    _run(seed, 400)


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(3600)
def test_a_million_samples_arrive_in_order() -> None:
    for seed in range(1000, 1050):
        _run(seed, 20_000)
