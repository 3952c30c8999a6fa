"""Write robot/humanoid_description/meshes/*.stl: the rounded shells that the humanoid wears.

    python tools/humanoid_shells.py

A shell is a stack of sections along z, each a superellipse, with rounded edges at both ends. A pad lies on a
shell: a visor on the head, a guard on the knee. The tables below give all measures in m, in the axes of the
link that wears the shell: x is forward, y to the left, z up. Every shell is its own mirror image, so both
sides of the robot wear the same files. Physics knows nothing of them (tools/humanoid_urdf.py).
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

TARGET = Path(__file__).resolve().parents[1] / 'robot' / 'humanoid_description' / 'meshes'
AROUND = 40  # points of a section
ALONG = 16  # sections between the rounded ends
EDGE = 5  # sections of a rounded end
RINGS, RIM = 7, 32  # rings of a pad, and points of its rim

Array: TypeAlias = 'np.ndarray[Any, np.dtype[np.float64]]'


@dataclass(frozen=True)
class Section:
    """A cut through a shell at height `z`: its halves along x and y, and how far forward its middle is."""

    z: float
    x: float
    y: float
    forward: float = 0.0


@dataclass(frozen=True)
class Shell:
    """Sections from the lowest to the highest.

    An exponent of 2 makes ellipses, a larger one rounded boxes. An end reaches `bottom` or `top` m beyond
    its last section and shrinks on the way by the share `closes`: 1 makes a dome.
    """

    sections: Sequence[Section]
    exponent: float = 2.5
    bottom: float = 0.01
    top: float = 0.01
    closes: tuple[float, float] = (0.3, 0.3)

    def rings(self) -> Array:
        """Return z, the halves along x and y, and the shift forward of each ring, from below to above."""
        given = np.array([(each.z, each.x, each.y, each.forward) for each in self.sections])
        heights = np.linspace(given[0, 0], given[-1, 0], ALONG)
        body = np.column_stack([heights, *(_smooth(given[:, 0], part, heights) for part in given[:, 1:].T)])
        low = _end(body[0], -self.bottom, self.closes[0])[::-1]
        return np.vstack((low, body, _end(body[-1], self.top, self.closes[1])))

    def point(self, z: Array, angle: Array, outside: Array | float = 0.0) -> Array:
        """Return points of the surface at heights and angles about z, some m outside of it."""
        rings = self.rings()
        x, y, forward = (np.interp(z, rings[:, 0], rings[:, part]) for part in (1, 2, 3))
        cos, sin = np.cos(angle), np.sin(angle)
        radius = (np.abs(cos / x) ** self.exponent + np.abs(sin / y) ** self.exponent) ** (
            -1.0 / self.exponent
        ) + outside
        return np.stack((forward + radius * cos, radius * sin, z), axis=-1)

    def triangles(self) -> Array:
        rings = self.rings()
        angles = np.linspace(0.0, math.tau, AROUND, endpoint=False)
        cos, sin = np.cos(angles), np.sin(angles)
        power = 2.0 / self.exponent
        outline = np.stack(
            (np.sign(cos) * np.abs(cos) ** power, np.sign(sin) * np.abs(sin) ** power), axis=-1
        )
        points = np.empty((len(rings), AROUND, 3))
        points[:, :, :2] = outline * rings[:, None, 1:3]
        points[:, :, 0] += rings[:, 3:]
        points[:, :, 2] = rings[:, :1]
        bottom, top = (points[end].mean(axis=0) for end in (0, -1))
        return np.concatenate((_strips(points), _fan(points[0][::-1], bottom), _fan(points[-1], top)), axis=0)


@dataclass(frozen=True)
class Pad:
    """A cushion on a shell, about the point at height `z` and at `angle` from straight ahead, in rad.

    `up` and `wide` are its halves in m and rad, `thick` is how far it stands out.
    """

    shell: Shell
    z: float
    up: float
    wide: float
    thick: float = 0.003
    angle: float = 0.0

    def triangles(self) -> Array:
        shares = (
            np.linspace(0.0, 1.0, RINGS + 1)[1:] ** 0.6
        )  # the rings lie closer where it bends: at the rim
        rim = np.linspace(0.0, math.tau, RIM, endpoint=False)
        cos, sin = np.cos(rim), np.sin(rim)
        square = (np.abs(cos) ** 4 + np.abs(sin) ** 4) ** -0.25  # a rounded rectangle
        angles = self.angle + self.wide * shares[:, None] * cos * square
        heights = self.z + self.up * shares[:, None] * sin * square
        stands = np.repeat(self.thick * (1.0 - 2.0 * shares[:, None] ** 8), RIM, axis=1)
        points = self.shell.point(heights, angles, stands)
        middle = self.shell.point(np.array(self.z), np.array(self.angle), self.thick)
        return np.concatenate((_strips(points[::-1]), _fan(points[0], middle)), axis=0)


def _smooth(at: Array, values: Array, wanted: Array) -> Array:
    """Return a smooth curve through the values (cubic, with the slopes of the neighbours' secants)."""
    slopes = np.gradient(values, at)
    spot = np.clip(np.searchsorted(at, wanted, side='right') - 1, 0, len(at) - 2)
    step = at[spot + 1] - at[spot]
    t = (wanted - at[spot]) / step
    return np.asarray(
        (1.0 + 2.0 * t) * (1.0 - t) ** 2 * values[spot]
        + t * (1.0 - t) ** 2 * step * slopes[spot]
        + t**2 * (3.0 - 2.0 * t) * values[spot + 1]
        + t**2 * (t - 1.0) * step * slopes[spot + 1]
    )


def _end(last: Array, reach: float, closes: float) -> Array:
    """Return the rings of a rounded end, away from the last section."""
    turns = np.linspace(0.0, math.pi / 2.0, EDGE + 1)[1:]
    shrunk = 1.0 - min(closes, 0.98) * (1.0 - np.cos(turns))
    return np.column_stack(
        (last[0] + reach * np.sin(turns), last[1] * shrunk, last[2] * shrunk, np.full(EDGE, last[3]))
    )


def _strips(rings: Array) -> Array:
    """Join rings of points, given from below to above, by triangles that face outwards."""
    here, above = rings[:-1], rings[1:]
    beside, across = np.roll(here, -1, axis=1), np.roll(above, -1, axis=1)
    first = np.stack((here, beside, across), axis=2)
    second = np.stack((here, across, above), axis=2)
    return np.concatenate((first, second)).reshape(-1, 3, 3)


def _fan(ring: Array, middle: Array) -> Array:
    return np.stack((ring, np.roll(ring, -1, axis=0), np.broadcast_to(middle, ring.shape)), axis=1)


CHEST = Shell(
    (
        Section(0.035, 0.062, 0.086),
        Section(0.12, 0.078, 0.108, 0.004),
        Section(0.22, 0.092, 0.138, 0.008),
        Section(0.29, 0.088, 0.146, 0.006),
        Section(0.335, 0.070, 0.122),
    ),
    exponent=3.0,
    bottom=0.015,
    top=0.03,
    closes=(0.2, 0.55),
)
PELVIS = Shell(
    (
        Section(-0.045, 0.052, 0.074),
        Section(-0.015, 0.064, 0.108),
        Section(0.03, 0.070, 0.118),
        Section(0.05, 0.066, 0.108),
    ),
    exponent=3.0,
    bottom=0.02,
    top=0.012,
    closes=(0.5, 0.25),
)
HEAD = Shell(
    (
        Section(0.018, 0.054, 0.050, 0.004),
        Section(0.05, 0.074, 0.066, 0.004),
        Section(0.09, 0.083, 0.074, 0.002),
        Section(0.125, 0.083, 0.074),
    ),
    exponent=2.4,
    bottom=0.015,
    top=0.062,
    closes=(0.45, 1.0),
)
SHOULDER = Shell(
    (Section(-0.045, 0.040, 0.040), Section(-0.01, 0.050, 0.050), Section(0.012, 0.050, 0.050)),
    exponent=2.0,
    bottom=0.006,
    top=0.042,
    closes=(0.15, 1.0),
)
UPPER_ARM = Shell(
    (
        Section(-0.185, 0.034, 0.034),
        Section(-0.12, 0.038, 0.038),
        Section(-0.05, 0.043, 0.042),
        Section(-0.015, 0.038, 0.038),
    ),
    exponent=2.3,
    bottom=0.012,
)
FOREARM = Shell(
    (
        Section(-0.168, 0.026, 0.027),
        Section(-0.12, 0.033, 0.034),
        Section(-0.07, 0.040, 0.040),
        Section(-0.035, 0.036, 0.036),
    ),
    exponent=2.3,
    bottom=0.008,
    top=0.014,
    closes=(0.3, 0.5),
)
HAND = Shell(
    (Section(-0.075, 0.017, 0.040), Section(-0.05, 0.022, 0.042), Section(-0.022, 0.018, 0.028)),
    exponent=3.2,
    bottom=0.008,
    top=0.008,
    closes=(0.4, 0.4),
)
FINGER = Shell(
    (Section(-0.06, 0.010, 0.006), Section(-0.03, 0.014, 0.007), Section(-0.002, 0.014, 0.007)),
    exponent=2.6,
    bottom=0.01,
    top=0.002,
    closes=(0.9, 0.3),
)
THIGH = Shell(
    (
        Section(-0.295, 0.048, 0.046),
        Section(-0.22, 0.058, 0.053, 0.003),
        Section(-0.13, 0.068, 0.062, 0.006),
        Section(-0.065, 0.060, 0.058, 0.002),
    ),
    exponent=2.4,
    bottom=0.012,
    top=0.02,
    closes=(0.3, 0.6),
)
SHIN = Shell(
    (
        Section(-0.29, 0.032, 0.032),
        Section(-0.20, 0.041, 0.038, -0.004),
        Section(-0.11, 0.053, 0.048, -0.008),
        Section(-0.045, 0.048, 0.046, 0.002),
    ),
    exponent=2.4,
    bottom=0.01,
    top=0.02,
    closes=(0.3, 0.6),
)
FOOT = Shell(
    (
        Section(-0.060, 0.106, 0.047, 0.03),
        Section(-0.045, 0.100, 0.046, 0.027),
        Section(-0.030, 0.074, 0.042, 0.008),
        Section(-0.012, 0.048, 0.036, -0.004),
    ),
    exponent=2.6,
    bottom=0.002,
    top=0.016,
    closes=(0.05, 0.5),
)
SOLE = Shell(
    (Section(-0.066, 0.108, 0.049, 0.03), Section(-0.060, 0.110, 0.050, 0.03)),
    exponent=3.0,
    bottom=0.004,
    top=0.004,
    closes=(0.04, 0.05),
)

SHELLS: dict[str, Shell | Pad] = {
    'chest': CHEST,
    'chest_panel': Pad(CHEST, 0.25, 0.062, 0.62, 0.004),
    'back_panel': Pad(CHEST, 0.21, 0.095, 0.55, 0.012, math.pi),
    'pelvis': PELVIS,
    'pelvis_panel': Pad(PELVIS, 0.008, 0.026, 0.55, 0.003),
    'head': HEAD,
    'visor': Pad(HEAD, 0.102, 0.040, 1.05, 0.004),
    'eyes': Pad(HEAD, 0.106, 0.007, 0.62, 0.0058),
    'shoulder': SHOULDER,
    'upper_arm': UPPER_ARM,
    'forearm': FOREARM,
    'forearm_panel': Pad(FOREARM, -0.10, 0.045, 0.6, 0.003),
    'hand': HAND,
    'finger': FINGER,
    'thigh': THIGH,
    'thigh_panel': Pad(THIGH, -0.17, 0.085, 0.62, 0.004),
    'shin': SHIN,
    'knee': Pad(SHIN, -0.075, 0.055, 0.75, 0.007),
    'foot': FOOT,
    'sole': SOLE,
}


def stl(triangles: Array) -> bytes:
    """Return a binary STL: a normal and three corners for each triangle."""
    corners = triangles.astype('<f4')
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    kept = length[:, 0] > 1e-12  # a triangle without an area has no normal
    record = np.zeros(
        int(kept.sum()), dtype=[('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('rest', '<u2')]
    )
    record['normal'] = (across / np.maximum(length, 1e-12))[kept]
    record['corners'] = corners[kept]
    return (
        b'humanoid, by tools/humanoid_shells.py'.ljust(80)
        + len(record).to_bytes(4, 'little')
        + record.tobytes()
    )


def main() -> int:
    TARGET.mkdir(parents=True, exist_ok=True)
    total = 0
    for name, shape in SHELLS.items():
        total += (TARGET / f'{name}.stl').write_bytes(stl(shape.triangles()))
    print(f'{TARGET}: {len(SHELLS)} files, {total / 1e6:.2f} MB')
    return 0


if __name__ == '__main__':
    sys.exit(main())
