"""Frames on a line that loses, changes and adds bytes."""

from __future__ import annotations

import random

import pytest

from humanoid.driver.frames import LONGEST, Decoder, Frame, joints_of, positions_of, states, targets

FRAMES = [targets(1, {0: 0.5, 30: -1.25}), states(1, [(0.5, 0.0, 0.25)] * 31), targets(255, {})]


def test_what_is_sent_arrives_however_it_is_cut() -> None:
    rng, decoder, came = random.Random(5), Decoder(), list[Frame]()
    data = b''.join(frame.encode() for frame in FRAMES * 20)
    while data:
        size = rng.randrange(1, 40)
        came += decoder.feed(data[:size])
        data = data[size:]
    assert came == FRAMES * 20
    assert decoder.damaged == 0
    assert positions_of(came[0]) == {0: 0.5, 30: -1.25}
    assert joints_of(came[1]) == [(0.5, 0.0, 0.25)] * 31


@pytest.mark.parametrize('seed', range(10))
def test_damage_costs_the_frames_that_it_hits_and_no_wrong_one_comes(seed: int) -> None:
    rng, decoder, came = random.Random(seed), Decoder(), list[Frame]()
    good = [Frame(1, number % 256, rng.randbytes(rng.randrange(60))) for number in range(300)]
    hit = 0
    for frame in good:
        data = bytearray(frame.encode())
        chance = rng.random()
        if chance < 0.1:
            del data[rng.randrange(len(data))]
        elif chance < 0.2:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        elif chance < 0.3:
            data[:0] = rng.randbytes(5)
            hit -= 1
        hit += chance < 0.3
        came += decoder.feed(bytes(data))
    came += decoder.feed(bytes(LONGEST + 10))  # what a damaged length waits for
    assert all(frame in good for frame in came)
    assert len(came) >= len(good) - 2 * hit - 5


@pytest.mark.parametrize('frame', [states(1, []), Frame(1, 0, b'abc'), Frame(9, 0, b'')])
def test_a_payload_of_another_kind_is_refused(frame: Frame) -> None:
    with pytest.raises(ValueError, match='no targets'):
        positions_of(frame)
