"""A test picture that moves, and who receives it."""

from __future__ import annotations

import pytest
from apps.programs.conftest import Run

from goalwire.apps.programs.image_tools import BARS, draw_bars


def test_bars_move_to_the_left_and_are_mirrored() -> None:
    picture = draw_bars(16, 2, 0)
    assert len(picture) == 16 * 2 * 3
    assert tuple(picture[:3]) == BARS[0]
    assert tuple(picture[45:48]) == BARS[7]
    assert tuple(draw_bars(16, 1, 2)[:3]) == BARS[1]
    assert tuple(draw_bars(16, 1, 0, is_flipped=True)[:3]) == BARS[7]


def test_pictures_are_published_and_received(run: Run) -> None:
    show = run('image_tools', 'showimage')
    show.expect('The page of "goalwire console" shows the pictures: choose the topic /image')
    camera = run('image_tools', 'cam2image', '--ros-args', '-p', 'frame_id:=eye', '-p', 'width:=64')
    camera.expect('Publishing image #1$')
    show.expect('Received image #eye')


@pytest.mark.parametrize(
    ('setting', 'reason'),
    [
        ('reliability:=perhaps', "the parameter reliability is 'perhaps': write reliable or best_effort"),
        ('width:=0', 'the parameter width is 0: it must be from 1 to 8192'),
        ('frequency:=0.0', 'the parameter frequency is 0.0: it must be above 0'),
    ],
)
def test_a_setting_that_does_not_fit_is_refused(run: Run, setting: str, reason: str) -> None:
    camera = run('image_tools', 'cam2image', '--ros-args', '-p', setting)
    assert camera.wait() == 1
    assert f'cam2image: {reason}' in camera.output
