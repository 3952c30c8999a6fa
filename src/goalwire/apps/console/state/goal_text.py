"""Describes a goal in a few words: 'to 2.0, 0.0 facing 90°', 'left_elbow 1.0', 'order 5'."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from goalwire.transforms.rigid import yaw_of

_MOST = 60
_FEW = 2


def describe_goal(request: Mapping[str, Any]) -> str:
    """Return a text of at most 60 characters about the data of a goal message; '' if it has no such data."""
    text = _place(request) or _joints(request) or ', '.join(_scalars(request)[:_FEW])
    return text if len(text) <= _MOST else f'{text[: _MOST - 1]}…'


def _place(request: Mapping[str, Any]) -> str:
    """Return where the goal leads, if it has a pose, poses, or x and y."""
    for value in request.values():
        if _is_pose(value):
            return _to(value)
        poses = _messages(value)
        if poses and all(map(_is_pose, poses)):
            if len(poses) < len(value):  # the data of a long list has neither its end nor all of its items
                return f'through more than {len(poses)}'
            passed = f'through {len(poses) - 1} ' if len(poses) > 1 else ''
            return f'{passed}{_to(poses[-1])}'
    x, y = request.get('x'), request.get('y')
    return f'to {x:.1f}, {y:.1f}' if _is_number(x) and _is_number(y) else ''


def _is_pose(value: Any) -> bool:
    """Return True for the data of a geometry_msgs/msg/PoseStamped."""
    if not isinstance(value, Mapping) or not isinstance(value.get('pose'), Mapping):
        return False
    pose = value['pose']
    return 'header' in value and all(
        isinstance(pose.get(part), Mapping) and set(names) <= pose[part].keys()
        for part, names in (('position', 'xy'), ('orientation', 'xyzw'))
    )


def _to(stamped: Mapping[str, Any]) -> str:
    position, turn = stamped['pose']['position'], stamped['pose']['orientation']
    x, y, z, w = (float(turn[name]) for name in 'xyzw')  # of a number that is not finite the data has a text
    text = f'to {float(position["x"]):.1f}, {float(position["y"]):.1f}'
    yaw = math.degrees(yaw_of((x, y, z, w)))
    return f'{text} facing {round(yaw)}°' if any((x, y, z, w)) and math.isfinite(yaw) else text


def _joints(request: Mapping[str, Any]) -> str:
    """Return the positions of the first joints, if the goal or its trajectory names joints."""
    inner = request.get('trajectory', request)
    if not isinstance(inner, Mapping):
        return ''
    last = (_messages(inner.get('points')) or [inner])[-1]
    names, positions = inner.get('joint_names'), last.get('positions')
    if not isinstance(names, Sequence) or not isinstance(positions, Sequence) or not names:
        return ''
    pairs = [
        f'{name} {position:.2f}'
        for name, position in zip(names, positions, strict=False)
        if _is_number(position)
    ]
    more = f', {len(pairs) - _FEW} more' if len(pairs) > _FEW else ''
    return ', '.join(pairs[:_FEW]) + more


def _scalars(request: Mapping[str, Any]) -> list[str]:
    """Return the numbers and short texts of a goal, with their names."""
    return [
        f'{name} {value:.4g}' if isinstance(value, float) else f'{name} {value}'
        for name, value in request.items()
        if isinstance(value, bool | int | float | str) and value != ''
    ]


def _messages(value: Any) -> list[Mapping[str, Any]]:
    """Return the messages of a list. The data of a long one ends with a text that says how long it was."""
    return [each for each in value if isinstance(each, Mapping)] if isinstance(value, list) else []


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
