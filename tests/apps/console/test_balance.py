"""The direction of a push that the console asks for."""

from __future__ import annotations

import math

import pytest

from goalwire.apps.console.state.balance import PUSH_S, push_values
from goalwire.transforms.rigid import Rigid


@pytest.mark.parametrize(('degrees', 'x', 'y'), [(0.0, 0.0, 80.0), (90.0, -80.0, 0.0), (180.0, 0.0, -80.0)])
def test_a_push_goes_from_where_the_robot_faces(degrees: float, x: float, y: float) -> None:
    half = math.pi / 4.0
    facing_left = Rigid((5.0, 5.0, 0.7), (0.0, 0.0, math.sin(half), math.cos(half)))
    values = push_values(80.0, degrees, facing_left)
    assert values['force'] == pytest.approx({'x': x, 'y': y, 'z': 0.0})
    assert values['duration'] == PUSH_S
