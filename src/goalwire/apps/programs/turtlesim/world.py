"""Turtles that move and draw, without ROS and without a window. The figures are those of ROS 2's turtlesim.

Lengths are in units of 45 pixels, the height of the original's turtle; angles in rad, counterclockwise from
the x axis; the lower left corner is (0, 0).
"""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from goalwire.apps.programs.turtlesim.canvas import SIDE, Canvas, Colour

PIXELS = 45
"""Pixels per unit of length."""
LENGTH = (SIDE - 1) / PIXELS
"""The length of each side in units, 11.09."""
STEP_S = 0.016
BACKGROUND: Colour = (0x45, 0x56, 0xFF)
PEN: Colour = (0xB3, 0xB8, 0xFF)
COMMAND_LASTS_S = 1.0
"""How long a turtle moves after its last command."""
LOOKS = 8
"""The number of pictures of turtles, which tell turtles apart."""


_FLOATS = struct.Struct('fff')


class Line(NamedTuple):
    """The line that a turtle has drawn in one step, in pixels from the upper left corner."""

    start: tuple[float, float]
    end: tuple[float, float]
    colour: Colour
    width: int


@dataclass
class Turtle:
    """The pose, the speed and the pen of a turtle."""

    name: str
    x: float
    y: float
    theta: float
    look: int = 0
    forward: float = 0.0
    sideways: float = 0.0
    turn: float = 0.0
    commanded_s: float = field(default=-math.inf, repr=False)
    pen: Colour | None = PEN
    width: int = 3

    def command(self, now_s: float, forward: float, sideways: float, turn: float) -> None:
        """Move at these speeds from now on: units/s and rad/s."""
        self.commanded_s = now_s
        self.forward, self.sideways, self.turn = forward, sideways, turn

    def pixel(self) -> tuple[float, float]:
        """Return the turtle's place on the canvas, in pixels."""
        return self.x * PIXELS, (LENGTH - self.y) * PIXELS


class World:
    """All turtles, and what they have drawn.

    `on_line` is called with each line, `on_wall` with a turtle's name and the place beyond the wall.
    """

    def __init__(self, on_line: Callable[[Line], None], on_wall: Callable[[str, float, float], None]) -> None:
        self.turtles: dict[str, Turtle] = {}
        self.canvas = Canvas(BACKGROUND)
        self._on_line = on_line
        self._on_wall = on_wall
        self._named = 0

    def spawn(self, name: str, x: float, y: float, theta: float) -> Turtle | None:
        """Add a turtle; an empty name becomes turtle1, turtle2, ... Returns None if the name is taken."""
        if not name:
            while not name or name in self.turtles:
                self._named += 1
                name = f'turtle{self._named}'
        elif name in self.turtles:
            return None
        x, y, theta = _FLOATS.unpack(_FLOATS.pack(x, y, theta))  # float32, as in a request
        turtle = Turtle(name, x, y, theta, look=random.randrange(LOOKS))  # noqa: S311 - a picture
        self.turtles[name] = turtle
        return turtle

    def spawn_first(self) -> Turtle:
        """Remove all turtles, and put turtle1 into the middle."""
        self.turtles.clear()
        self._named = 0
        turtle = self.spawn('', LENGTH / 2, LENGTH / 2, 0.0)
        assert turtle is not None
        return turtle

    def teleport(self, turtle: Turtle, x: float, y: float, theta: float) -> None:
        """Move a turtle to a place at once; its pen draws the line."""
        before = turtle.pixel()
        turtle.x, turtle.y, turtle.theta = x, min(y, LENGTH), theta
        self._draw(turtle, before)

    def teleport_by(self, turtle: Turtle, forward: float, turn: float) -> None:
        """Turn a turtle, then move it forward, at once."""
        theta = turtle.theta + turn
        self.teleport(
            turtle, turtle.x + math.cos(theta) * forward, turtle.y + math.sin(theta) * forward, theta
        )

    def step(self, turtle: Turtle, now_s: float) -> None:
        """Move a turtle by one step of 16 ms, and hold it at the walls."""
        if now_s - turtle.commanded_s > COMMAND_LASTS_S:
            turtle.forward = turtle.sideways = turtle.turn = 0.0
        before = turtle.pixel()
        turtle.theta = normalize(turtle.theta + turtle.turn * STEP_S)
        cosine, sine = math.cos(turtle.theta), math.sin(turtle.theta)
        x = turtle.x + (cosine * turtle.forward - sine * turtle.sideways) * STEP_S
        y = turtle.y + (sine * turtle.forward + cosine * turtle.sideways) * STEP_S
        if not (0.0 <= x <= LENGTH and 0.0 <= y <= LENGTH):
            self._on_wall(turtle.name, x, y)
        turtle.x, turtle.y = (min(max(part, 0.0), LENGTH) for part in (x, y))
        if turtle.pixel() != before:
            self._draw(turtle, before)

    def _draw(self, turtle: Turtle, before: tuple[float, float]) -> None:
        if turtle.pen is not None:
            line = Line(before, turtle.pixel(), turtle.pen, turtle.width)
            self.canvas.draw_line(*line)
            self._on_line(line)


def normalize(angle: float) -> float:
    """Return an angle of at least -pi and less than pi."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
