"""Groups joints into limbs: joints in a row, without a branch between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from goalwire.transforms.urdf import Joint


def limbs_of(joints: Sequence[Joint]) -> dict[str, list[Joint]]:
    """Return the free joints of a robot by limb, in the order of `joints`.

    `joints` are all joints of a description, fixed ones included. A limb ends at a link from which several
    rows of free joints go on, as a trunk does at the shoulders. A limb of one joint has its name, a longer
    one has the names of its first and its last joint.
    """
    above = {joint.child: joint for joint in joints}
    before: dict[str, str] = {}
    """By free joint: the nearest free joint between it and the root; '' if there is none."""
    for joint in joints:
        if joint.is_free:
            at = above.get(joint.parent)
            while at is not None and not at.is_free:
                at = above.get(at.parent)
            before[joint.name] = '' if at is None else at.name
    branches = Counter(before.values())

    def first_of(name: str) -> str:
        while before[name] and branches[before[name]] == 1:
            name = before[name]
        return name

    limbs: dict[str, list[Joint]] = {}
    for joint in joints:
        if joint.is_free:
            limbs.setdefault(first_of(joint.name), []).append(joint)
    return {
        limb[0].name if len(limb) == 1 else f'{limb[0].name} to {limb[-1].name}': limb
        for limb in limbs.values()
    }
