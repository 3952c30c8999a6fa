"""The plan of the divergent component of motion, against its equation."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('mujoco', reason='the walker is part of the physics: pip install mujoco-core daqp')

from humanoid.walking.dcm import Segment, reference

OMEGA = 3.7
LEFT, RIGHT, MIDDLE = np.array((0.0, 0.09)), np.array((0.2, -0.09)), np.array((0.1, 0.0))
PLAN = [
    Segment(0.5, MIDDLE, LEFT),
    Segment(0.4, LEFT, LEFT),
    Segment(0.1, LEFT, RIGHT),
    Segment(0.3, RIGHT, MIDDLE),
]


def test_the_plan_obeys_the_equation_of_the_dcm() -> None:
    step = 1e-5
    for moment in (0.1, 0.3, 0.45):
        dcm, push = reference(PLAN, moment, OMEGA)
        later, _ = reference(PLAN, moment + step, OMEGA)
        assert (later - dcm) / step == pytest.approx(OMEGA * (dcm - push), abs=1e-3)


def test_the_plan_ends_at_rest_above_the_last_point() -> None:
    dcm, push = reference(PLAN[-1:], 0.3, OMEGA)
    assert dcm == pytest.approx(MIDDLE)
    assert push == pytest.approx(MIDDLE)


def test_from_one_segment_to_the_next_the_plan_makes_no_leap() -> None:
    for number, segment in enumerate(PLAN[:-1]):
        before, _ = reference(PLAN[number:], segment.duration, OMEGA)
        after, _ = reference(PLAN[number + 1 :], 0.0, OMEGA)
        assert before == pytest.approx(after)
