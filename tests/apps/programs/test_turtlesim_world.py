"""Turtles without ROS: how they move, what they draw, where the walls are."""

from __future__ import annotations

import math
import struct
import zlib

import pytest

from goalwire.apps.programs.turtlesim.canvas import SIDE, Canvas
from goalwire.apps.programs.turtlesim.world import (
    BACKGROUND,
    COMMAND_LASTS_S,
    LENGTH,
    PEN,
    STEP_S,
    Line,
    Turtle,
    World,
    normalize,
)


class Watched:
    """A world with its first turtle, and what it tells."""

    def __init__(self) -> None:
        self.lines: list[Line] = []
        self.walls: list[tuple[str, float, float]] = []
        self.world = World(self.lines.append, lambda *hit: self.walls.append(hit))
        self.turtle = self.world.spawn_first()

    def drive(self, seconds: float, forward: float, turn: float = 0.0, sideways: float = 0.0) -> Turtle:
        """Command every step."""
        for step in range(round(seconds / STEP_S)):
            self.turtle.command(step * STEP_S, forward, sideways, turn)
            self.world.step(self.turtle, step * STEP_S)
        return self.turtle


def test_the_first_turtle_stands_in_the_middle() -> None:
    turtle = Watched().turtle
    assert (turtle.name, turtle.theta) == ('turtle1', 0.0)
    assert f'{turtle.x:f} {turtle.y:f}' == '5.544445 5.544445'


def test_a_turtle_drives_ahead_and_draws() -> None:
    watched = Watched()
    turtle = watched.drive(1.008, 2.0)
    assert turtle.x == pytest.approx(5.544445 + 2.016)
    assert watched.world.canvas.colour_at(*turtle.pixel()) == PEN
    assert watched.world.canvas.colour_at(10.0, 10.0) == BACKGROUND
    assert len(watched.lines) == 63


def test_a_turtle_drives_a_circle() -> None:
    turtle = Watched().drive(2.0 * math.pi, 1.0, turn=1.0)
    assert turtle.x == pytest.approx(5.544, abs=0.05)
    assert turtle.y == pytest.approx(5.544, abs=0.05)


def test_a_command_lasts_for_a_second() -> None:
    watched = Watched()
    watched.turtle.command(0.0, 1.0, 0.0, 0.0)
    watched.world.step(watched.turtle, COMMAND_LASTS_S)
    assert watched.turtle.forward == 1.0
    watched.world.step(watched.turtle, COMMAND_LASTS_S + STEP_S)
    assert watched.turtle.forward == 0.0


def test_a_wall_holds_a_turtle() -> None:
    watched = Watched()
    turtle = watched.drive(8.0, 1.0)
    assert turtle.x == LENGTH
    assert watched.walls[0][0] == 'turtle1'
    assert watched.walls[0][1] > LENGTH


def test_a_lifted_pen_draws_nothing() -> None:
    watched = Watched()
    watched.turtle.pen = None
    watched.drive(1.0, 1.0)
    assert watched.lines == []


def test_a_teleport_draws_its_way() -> None:
    watched = Watched()
    watched.world.teleport(watched.turtle, 1.0, 2.0, 0.5)
    assert (watched.turtle.x, watched.turtle.y, watched.turtle.theta) == (1.0, 2.0, 0.5)
    watched.world.teleport_by(watched.turtle, 1.0, math.pi / 2 - 0.5)
    assert watched.turtle.x == pytest.approx(1.0)
    assert watched.turtle.y == pytest.approx(3.0)
    assert len(watched.lines) == 2


def test_names_are_given_in_order_and_never_twice() -> None:
    world = Watched().world
    assert world.spawn('turtle2', 1.0, 1.0, 0.0) is not None
    third = world.spawn('', 1.0, 1.0, 0.0)
    assert third is not None
    assert third.name == 'turtle3'
    assert world.spawn('turtle1', 1.0, 1.0, 0.0) is None


@pytest.mark.parametrize(('angle', 'same'), [(0.0, 0.0), (math.pi, -math.pi), (-7.0, 2 * math.pi - 7.0)])
def test_angles_are_kept_within_a_turn(angle: float, same: float) -> None:
    assert normalize(angle) == pytest.approx(same)


def test_a_line_is_as_wide_as_the_pen() -> None:
    canvas = Canvas((0, 0, 0))
    canvas.draw_line((100.0, 100.0), (200.0, 100.0), (255, 0, 0), 5)
    column = [canvas.colour_at(150.0, float(row)) for row in range(90, 111)]
    assert column.count((255, 0, 0)) == 5


def test_a_line_beyond_the_edge_is_cut() -> None:
    canvas = Canvas((0, 0, 0))
    canvas.draw_line((-50.0, 499.0), (600.0, 499.0), (1, 2, 3), 9)
    assert canvas.colour_at(0.0, 499.0) == canvas.colour_at(499.0, 499.0) == (1, 2, 3)


def test_the_picture_is_a_png() -> None:
    canvas = Canvas((9, 8, 7))
    png = canvas.to_png()
    width, height = struct.unpack('>II', png[16:24])
    assert (png[:8], width, height) == (b'\x89PNG\r\n\x1a\n', SIDE, SIDE)
    length = struct.unpack('>I', png[33:37])[0]
    rows = zlib.decompress(png[41 : 41 + length])
    assert rows[:4] == bytes((0, 9, 8, 7))
    assert len(rows) == SIDE * (SIDE * 3 + 1)
