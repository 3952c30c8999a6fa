"""The tree of frames that TF publishes, and where each of them is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from goalwire.records import record
from goalwire.transforms.rigid import IDENTITY, Rigid

MOST_AXES = 300
"""The largest number of frames whose axes are drawn; a browser draws a label for each."""


@record
class Placed:
    """A frame, the topmost frame above it, and its pose there."""

    top: str
    pose: Rigid


def place_all(frames: Mapping[str, tuple[str, Rigid]]) -> dict[str, Placed]:
    """Return the place of each frame, and of each parent.

    `frames` has the parent of each frame, and its pose there. In a circle of frames, the first one that is
    met stands for the topmost.
    """
    placed: dict[str, Placed] = {}
    for name in frames:
        chain: list[str] = []
        at = name
        while at not in placed and at in frames and at not in chain:
            chain.append(at)
            at = frames[at][0]
        if at not in placed:
            placed[at] = Placed(at, IDENTITY)
            if at in chain:
                chain = chain[chain.index(at) + 1 :] + chain[: chain.index(at)]
        for below in reversed(chain):
            parent, motion = frames[below]
            above = placed.get(parent, Placed(parent, IDENTITY))
            placed[below] = Placed(above.top, above.pose.after(motion))
    return placed


def tree_of(frames: Mapping[str, tuple[str, Rigid]], placed: Mapping[str, Placed]) -> list[dict[str, Any]]:
    """Return the trees of frames as nodes `{id, children}`, with siblings in the order of their names."""
    nodes: dict[str, dict[str, Any]] = {name: {'id': name, 'children': []} for name in sorted(placed)}
    roots = []
    for name, node in nodes.items():
        if placed[name].top == name:
            roots.append(node)
        else:
            nodes[frames[name][0]]['children'].append(node)
    return roots


def numbers_of(pose: Rigid) -> list[float]:
    """Return a pose as x, y, z and the quaternion x, y, z, w, with five decimals."""
    return [round(number, 5) for number in (*pose.translation, *pose.rotation)]
