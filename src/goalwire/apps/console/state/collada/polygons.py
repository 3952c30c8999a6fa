"""Polygons, strips and fans as triangles.

Corners are counted through all polygons of an element: those of the second polygon follow those of the first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from goalwire.apps.console.state.collada.document import Floats, Integers

_MOST_TRIES = 100_000
"""How many corners of an element's polygons are tried as ears: some 2 s. After that, concave polygons are cut
like convex ones.
"""
_FLAT = 1e-9
"""The largest sine, to a polygon's size, of a corner that counts as straight."""


def triangles_of_polygons(sizes: Integers, spots: Floats) -> Integers:
    """Return the triangles (m, 3) of polygons with these numbers of corners, at these places (k, 3)."""
    firsts = np.cumsum(sizes) - sizes
    order = np.argsort(sizes, kind='stable')
    kinds, begins, counts = np.unique(sizes[order], return_index=True, return_counts=True)
    found, tries = [np.empty((0, 3), np.int64)], [_MOST_TRIES]
    for size, begin, count in zip(kinds.tolist(), begins.tolist(), counts.tolist(), strict=True):
        if size < 3:
            continue
        corners = firsts[order[begin : begin + count], None] + np.arange(size)
        fans = np.empty((count, size - 2, 3), np.int64)
        fans[:, :, 0] = corners[:, :1]
        fans[:, :, 1] = corners[:, 1:-1]
        fans[:, :, 2] = corners[:, 2:]
        if size > 3:
            flat, concave = _flattened(spots[corners])
            for at in np.flatnonzero(concave).tolist():
                fans[at] = corners[at][_ears(flat[at], tries)]
        found.append(fans.reshape(-1, 3))
    return np.concatenate(found)


def triangles_of_strips(sizes: Integers) -> Integers:
    """Return the triangles of strips: each corner from the third on makes one with the two before it."""
    starts = _starts(sizes)
    turned = starts[:, 1] % 2 == 1  # every second triangle of a strip runs the other way round
    first = starts.sum(axis=1)
    return np.stack([first, first + 1 + turned, first + 2 - turned], axis=1)


def triangles_of_fans(sizes: Integers) -> Integers:
    """Return the triangles of fans: each corner from the third on ends one that begins at the first."""
    starts = _starts(sizes)
    second = starts.sum(axis=1) + 1
    return np.stack([starts[:, 0], second, second + 1], axis=1)


def _starts(sizes: Integers) -> Integers:
    """For each triangle: the first corner of its strip, and the triangle's number in the strip."""
    counts = np.maximum(sizes - 2, 0)
    firsts = np.repeat(np.cumsum(sizes) - sizes, counts)
    numbers = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([firsts, numbers], axis=1)


def _flattened(spots: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return polygons (n, size, 3) in their planes (n, size, 2), counterclockwise, and which are concave."""
    spots = spots - spots[:, :1]
    spots = spots / np.maximum(np.abs(spots).max(axis=(1, 2), keepdims=True), 1e-300)
    normals = np.cross(spots, np.roll(spots, -1, axis=1)).sum(axis=1)
    drop = np.argmax(np.abs(normals), axis=1)  # seen along the axis that is the nearest to the normal
    rows = np.arange(len(spots))
    across = np.stack([(drop + 1) % 3, (drop + 2) % 3], axis=1)
    flat = np.take_along_axis(spots, across[:, None, :], axis=2)
    flat[normals[rows, drop] < 0, :, 1] *= -1
    before, after = flat - np.roll(flat, 1, axis=1), np.roll(flat, -1, axis=1) - flat
    turns = before[:, :, 0] * after[:, :, 1] - before[:, :, 1] * after[:, :, 0]
    return flat, np.asarray((turns < -_FLAT).any(axis=1))


def _ears(flat: Floats, tries: list[int]) -> Integers:
    """Cut a polygon, seen in its plane, into triangles, one corner after the other."""
    left, found = list(range(len(flat))), []
    at = waits = 0
    while len(left) > 3 and tries[0] > 0 and waits < len(left):
        tries[0] -= 1
        at %= len(left)
        ear = [left[at - 1], left[at], left[(at + 1) % len(left)]]
        if _is_ear(flat[ear], flat[left]):
            found.append(ear)
            del left[at]
            waits = 0
        else:
            at += 1
            waits += 1
    found += [[left[0], left[place], left[place + 1]] for place in range(1, len(left) - 1)]
    return np.array(found)


def _is_ear(ear: Floats, others: Floats) -> bool:
    """True if the corner is convex, and no corner of the rest lies inside the triangle."""
    sides = np.roll(ear, -1, axis=0) - ear
    if sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0] < -_FLAT:
        return False
    away = others[:, None, :] - ear
    inside = (sides[:, 0] * away[:, :, 1] - sides[:, 1] * away[:, :, 0] > _FLAT).all(axis=1)
    return not inside.any()
