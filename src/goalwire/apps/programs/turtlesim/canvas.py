"""The picture on which turtles draw, as pixels: for the colour sensor and for browsers that connect later."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from goalwire.idl.png import png

Colour: TypeAlias = tuple[int, int, int]

SIDE = 500
"""Pixels of each side, as in ROS 2's turtlesim."""


class Canvas:
    """A square of pixels; (0, 0) is its upper left corner."""

    def __init__(self, background: Colour) -> None:
        self._pixels = bytearray()
        self.fill(background)

    def fill(self, colour: Colour) -> None:
        """Paint the whole canvas."""
        self._pixels[:] = bytes(colour) * (SIDE * SIDE)

    def colour_at(self, x: float, y: float) -> Colour:
        """Return the colour of the pixel that is nearest to a point."""
        column, row = (min(max(round(part), 0), SIDE - 1) for part in (x, y))
        start = (row * SIDE + column) * 3
        red, green, blue = self._pixels[start : start + 3]
        return red, green, blue

    def draw_line(
        self, start: tuple[float, float], end: tuple[float, float], colour: Colour, width: int
    ) -> None:
        """Draw a line with round ends, `width` pixels wide."""
        steps = max(math.ceil(math.dist(start, end)), 1)
        for step in range(steps + 1):
            part = step / steps
            self._stamp(
                start[0] + (end[0] - start[0]) * part,
                start[1] + (end[1] - start[1]) * part,
                colour,
                width / 2,
            )

    def _stamp(self, x: float, y: float, colour: Colour, radius: float) -> None:
        for row in range(max(math.ceil(y - radius), 0), min(math.floor(y + radius), SIDE - 1) + 1):
            half = math.sqrt(max(radius**2 - (row - y) ** 2, 0.0))
            left, right = max(math.ceil(x - half), 0), min(math.floor(x + half), SIDE - 1)
            if left <= right:
                start = (row * SIDE + left) * 3
                self._pixels[start : start + (right - left + 1) * 3] = bytes(colour) * (right - left + 1)

    def to_png(self) -> bytes:
        """Return the picture as a PNG file."""
        return png(np.frombuffer(self._pixels, np.uint8).reshape(SIDE, SIDE, 3))
