"""Joints in groups: a limb goes on as long as no other one branches off."""

from __future__ import annotations

from goalwire.apps.console.state.limbs import limbs_of
from goalwire.transforms.urdf import Joint


def joint(name: str, parent: str, child: str, kind: str = 'revolute') -> Joint:
    return Joint(name, kind, parent, child)


def test_arms_and_legs_are_limbs() -> None:
    body = [
        joint('waist', 'pelvis', 'trunk'),
        joint('to_shoulder', 'trunk', 'left_side', 'fixed'),
        joint('left_shoulder', 'left_side', 'left_upper'),
        joint('left_elbow', 'left_upper', 'left_lower'),
        joint('right_shoulder', 'trunk', 'right_upper'),
        joint('right_elbow', 'right_upper', 'right_lower'),
        joint('left_knee', 'pelvis', 'left_shank'),
        joint('right_knee', 'pelvis', 'right_shank'),
    ]
    assert {name: [each.name for each in limb] for name, limb in limbs_of(body).items()} == {
        'waist': ['waist'],
        'left_shoulder to left_elbow': ['left_shoulder', 'left_elbow'],
        'right_shoulder to right_elbow': ['right_shoulder', 'right_elbow'],
        'left_knee': ['left_knee'],
        'right_knee': ['right_knee'],
    }


def test_an_arm_alone_is_one_limb() -> None:
    arm = [joint(f'joint_{number}', f'link_{number}', f'link_{number + 1}') for number in range(6)]
    assert [len(limb) for limb in limbs_of(arm).values()] == [6]
    assert limbs_of([]) == {}
