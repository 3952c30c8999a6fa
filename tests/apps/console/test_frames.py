"""Where the frames of TF are, as trees."""

from __future__ import annotations

import pytest

from goalwire.apps.console.state.frames import place_all, tree_of
from goalwire.transforms.rigid import Rigid

UPRIGHT = (0.0, 0.0, 0.0, 1.0)
STEP = Rigid((1.0, 0.0, 0.0), UPRIGHT)


def test_each_frame_is_placed_under_the_topmost_one() -> None:
    frames = {'hand': ('arm', STEP), 'arm': ('base', STEP), 'base': ('odom', STEP), 'lamp': ('wall', STEP)}
    placed = place_all(frames)
    assert {name: (at.top, at.pose.translation[0]) for name, at in placed.items()} == {
        'odom': ('odom', 0.0),
        'base': ('odom', 1.0),
        'arm': ('odom', 2.0),
        'hand': ('odom', 3.0),
        'wall': ('wall', 0.0),
        'lamp': ('wall', 1.0),
    }
    assert tree_of(frames, placed) == [
        {
            'id': 'odom',
            'children': [
                {'id': 'base', 'children': [{'id': 'arm', 'children': [{'id': 'hand', 'children': []}]}]}
            ],
        },
        {'id': 'wall', 'children': [{'id': 'lamp', 'children': []}]},
    ]


@pytest.mark.parametrize('first', ['a', 'b', 'c', 'd', 'leaf'])
def test_frames_that_form_a_circle_are_placed_once(first: str) -> None:
    circle = {'a': ('c', STEP), 'b': ('a', STEP), 'c': ('b', STEP), 'leaf': ('b', STEP), 'd': ('d', STEP)}
    frames = {first: circle[first], **circle}
    placed = place_all(frames)
    assert placed.keys() == circle.keys()
    roots = tree_of(frames, placed)
    assert len(roots) == 2

    def count(node: dict) -> int:  # type: ignore[type-arg]
        return 1 + sum(map(count, node['children']))

    assert sum(map(count, roots)) == 5
