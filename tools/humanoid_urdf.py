"""Write robot/humanoid_description/urdf/humanoid.urdf: the humanoid's body, from the tables below.

    python tools/humanoid_urdf.py

The inertia of each link is that of its shape as a solid of even density, about its own centre. Physics has
these shapes; eyes see the shells of tools/humanoid_shells.py instead.
Metres, kilograms, radians; x is forward, y to the left, z up. The left side is written down here; the right
one is its mirror image.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

TARGET = Path(__file__).resolve().parents[1] / 'robot' / 'humanoid_description' / 'urdf' / 'humanoid.urdf'

Vector = tuple[float, float, float]
NOWHERE: Vector = (0.0, 0.0, 0.0)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
MINUS_Y: Vector = (0.0, -1.0, 0.0)

MATERIALS = {
    'body': (0.87, 0.89, 0.92),
    'accent': (0.16, 0.47, 0.80),
    'joint': (0.25, 0.27, 0.30),
    'sole': (0.12, 0.12, 0.13),
    'glass': (0.05, 0.08, 0.12),
    'light': (0.35, 0.85, 1.0),
}


@dataclass(frozen=True)
class Shape:
    """A box (x, y, z), a cylinder (radius, length along z), a sphere (radius), or the mesh of a file."""

    kind: str
    size: Sequence[float]
    at: Vector = NOWHERE
    material: str = 'body'
    file: str = ''

    def inertia(self, mass: float) -> Vector:
        """Return the moments about the shape's own axes, kg·m²."""
        if self.kind == 'box':
            x, y, z = (side**2 for side in self.size)
            return mass * (y + z) / 12.0, mass * (x + z) / 12.0, mass * (x + y) / 12.0
        if self.kind == 'cylinder':
            radius, length = self.size
            across = mass * (3.0 * radius**2 + length**2) / 12.0
            return across, across, mass * radius**2 / 2.0
        same = 0.4 * mass * self.size[0] ** 2
        return same, same, same

    def xml(self) -> str:
        if self.kind == 'box':
            return f'<box size="{_numbers(self.size)}"/>'
        if self.kind == 'mesh':
            return f'<mesh filename="package://humanoid_description/meshes/{self.file}.stl"/>'
        if self.kind == 'cylinder':
            return f'<cylinder radius="{self.size[0]:g}" length="{self.size[1]:g}"/>'
        return f'<sphere radius="{self.size[0]:g}"/>'


@dataclass(frozen=True)
class Link:
    """A body. Its first shape carries the mass; `bumps` says whether it can be run into.

    The link is seen by its shapes, but by `shells` in place of the first one if it has any.
    """

    name: str
    mass: float = 0.0
    shapes: tuple[Shape, ...] = ()
    bumps: bool = True
    shells: tuple[Shape, ...] = ()

    @property
    def seen(self) -> Sequence[Shape]:
        return (*self.shells, *self.shapes[1:]) if self.shells else self.shapes


@dataclass(frozen=True)
class Joint:
    """How `child` hangs on `parent`. Without an axis it is fixed. Speed and torque are the greatest."""

    name: str
    parent: str
    child: Link
    at: Vector
    axis: Vector | None = None
    limits: tuple[float, float] = (0.0, 0.0)
    speed: float = 0.0
    effort: float = 0.0
    damping: float = 0.0
    prismatic: bool = False
    mimics: str = ''
    turned: Vector = NOWHERE  # roll, pitch and yaw of the child in the parent


def _box(x: float, y: float, z: float, at: Vector = NOWHERE, material: str = 'body') -> Shape:
    return Shape('box', (x, y, z), at, material)


def _cylinder(radius: float, length: float, at: Vector = NOWHERE, material: str = 'body') -> Shape:
    return Shape('cylinder', (radius, length), at, material)


def _sphere(radius: float, at: Vector = NOWHERE, material: str = 'joint') -> Shape:
    return Shape('sphere', (radius,), at, material)


def _shell(file: str, material: str = 'body', at: Vector = NOWHERE) -> Shape:
    return Shape('mesh', (), at, material, file)


PELVIS = Link(
    'base_link',
    6.0,
    (_box(0.14, 0.24, 0.12), _cylinder(0.055, 0.05, (0.0, 0.0, 0.08), 'joint')),
    shells=(_shell('pelvis'), _shell('pelvis_panel', 'accent')),
)

TRUNK = (
    Joint('base_footprint_joint', 'base_link', Link('base_footprint'), (0.0, 0.0, -0.80)),
    Joint('imu_joint', 'base_link', Link('imu_link'), (0.0, 0.0, 0.03)),
    Joint('laser_joint', 'base_link', Link('laser'), (0.07, 0.0, -0.10)),
    Joint(
        'waist',
        'base_link',
        Link(
            'torso',
            13.1,
            (_box(0.17, 0.28, 0.34, (0.0, 0.0, 0.19)),),
            shells=(_shell('chest'), _shell('chest_panel', 'accent'), _shell('back_panel', 'joint')),
        ),
        (0.0, 0.0, 0.08),
        Z,
        (-1.5, 1.5),
        speed=2.0,
        effort=120.0,
        damping=4.0,
    ),
    Joint(
        'head_pan',
        'torso',
        Link('neck', 0.5, (_cylinder(0.04, 0.05, (0.0, 0.0, 0.02), 'joint'),), bumps=False),
        (0.0, 0.0, 0.39),
        Z,
        (-1.4, 1.4),
        speed=3.0,
        effort=8.0,
        damping=0.4,
    ),
    Joint(
        'head_tilt',
        'neck',
        Link(
            'head',
            3.0,
            (_box(0.16, 0.15, 0.18, (0.0, 0.0, 0.095)),),
            shells=(_shell('head'), _shell('visor', 'glass'), _shell('eyes', 'light')),
        ),
        (0.0, 0.0, 0.05),
        Y,
        (-0.6, 0.8),
        speed=3.0,
        effort=8.0,
        damping=0.4,
    ),
    Joint('camera_joint', 'head', Link('camera_link'), (0.085, 0.0, 0.11)),
    Joint(  # as REP 103 wants it: z forward, x to the right, y down
        'camera_optical_joint',
        'camera_link',
        Link('camera_optical_frame'),
        NOWHERE,
        turned=(-math.pi / 2.0, 0.0, -math.pi / 2.0),
    ),
)

LEFT_ARM = (
    Joint(
        'left_arm_shoulder',
        'torso',
        Link('left_shoulder', 0.4, (_sphere(0.045),), bumps=False),
        (0.0, 0.20, 0.31),
        MINUS_Y,
        (-2.9, 2.9),
        speed=2.0,
        effort=40.0,
        damping=4.0,
    ),
    Joint(
        'left_arm_shoulder_roll',
        'left_shoulder',
        Link(
            'left_shoulder_cap',
            0.4,
            (_cylinder(0.04, 0.06, (0.0, 0.0, -0.02), 'accent'),),
            bumps=False,
            shells=(_shell('shoulder', 'accent'),),
        ),
        (0.0, 0.03, 0.0),
        X,
        (-0.2, 2.6),
        speed=2.0,
        effort=40.0,
        damping=4.0,
    ),
    Joint(
        'left_arm_shoulder_yaw',
        'left_shoulder_cap',
        Link(
            'left_upper_arm',
            1.0,
            (_cylinder(0.037, 0.20, (0.0, 0.0, -0.10)),),
            shells=(_shell('upper_arm'),),
        ),
        (0.0, 0.0, -0.04),
        Z,
        (-1.6, 1.6),
        speed=2.5,
        effort=25.0,
        damping=2.0,
    ),
    Joint(
        'left_arm_elbow',
        'left_upper_arm',
        Link(
            'left_forearm',
            0.7,
            (_cylinder(0.033, 0.16, (0.0, 0.0, -0.10)), _sphere(0.038)),
            shells=(_shell('forearm'), _shell('forearm_panel', 'accent')),
        ),
        (0.0, 0.0, -0.22),
        MINUS_Y,
        (0.0, 2.4),
        speed=2.5,
        effort=25.0,
        damping=2.0,
    ),
    Joint(
        'left_arm_wrist_yaw',
        'left_forearm',
        Link('left_wrist', 0.2, (_cylinder(0.03, 0.04, (0.0, 0.0, -0.02), 'joint'),), bumps=False),
        (0.0, 0.0, -0.18),
        Z,
        (-2.0, 2.0),
        speed=3.0,
        effort=8.0,
        damping=0.4,
    ),
    Joint(
        'left_arm_wrist_pitch',
        'left_wrist',
        Link('left_wrist_cross', 0.15, (_sphere(0.03),), bumps=False),
        (0.0, 0.0, -0.04),
        Y,
        (-1.2, 1.2),
        speed=3.0,
        effort=8.0,
        damping=0.4,
    ),
    Joint(
        'left_arm_wrist_roll',
        'left_wrist_cross',
        Link(
            'left_hand',
            0.25,
            (_box(0.04, 0.09, 0.06, (0.0, 0.0, -0.05), 'accent'),),
            shells=(_shell('hand'),),
        ),
        NOWHERE,
        X,
        (-0.8, 0.8),
        speed=3.0,
        effort=8.0,
        damping=0.4,
    ),
    Joint(
        'left_gripper',
        'left_hand',
        Link(
            'left_finger',
            0.05,
            (_box(0.03, 0.012, 0.07, (0.0, 0.006, -0.035), 'joint'),),
            shells=(_shell('finger', 'joint', (0.0, 0.006, 0.0)),),
        ),
        (0.0, 0.0, -0.08),
        Y,
        (0.0, 0.04),
        speed=0.1,
        effort=40.0,
        damping=10.0,
        prismatic=True,
    ),
    Joint(
        'left_gripper_mirror',
        'left_hand',
        Link(
            'left_thumb',
            0.05,
            (_box(0.03, 0.012, 0.07, (0.0, -0.006, -0.035), 'joint'),),
            shells=(_shell('finger', 'joint', (0.0, -0.006, 0.0)),),
        ),
        (0.0, 0.0, -0.08),
        MINUS_Y,
        (0.0, 0.04),
        speed=0.1,
        effort=40.0,
        damping=10.0,
        prismatic=True,
        mimics='left_gripper',
    ),
    Joint('left_tool_joint', 'left_hand', Link('left_tool'), (0.0, 0.0, -0.12)),
)

LEFT_LEG = (
    Joint(
        'left_hip_yaw',
        'base_link',
        Link('left_hip', 0.8, (_cylinder(0.05, 0.05, material='joint'),), bumps=False),
        (0.0, 0.09, -0.05),
        Z,
        (-0.8, 0.8),
        speed=8.0,
        effort=80.0,
        damping=4.0,
    ),
    Joint(
        'left_hip_roll',
        'left_hip',
        Link('left_hip_cross', 0.8, (_sphere(0.055),), bumps=False),
        NOWHERE,
        X,
        (-0.4, 0.7),
        speed=8.0,
        effort=120.0,
        damping=6.0,
    ),
    Joint(
        'left_hip_pitch',
        'left_hip_cross',
        Link(
            'left_thigh',
            4.5,
            (_cylinder(0.06, 0.22, (0.0, 0.0, -0.19)),),
            shells=(_shell('thigh'), _shell('thigh_panel', 'accent')),
        ),
        NOWHERE,
        Y,
        (-2.0, 0.9),
        speed=8.0,
        effort=160.0,
        damping=8.0,
    ),
    Joint(
        'left_knee',
        'left_thigh',
        Link(
            'left_shin',
            3.0,
            (_cylinder(0.05, 0.26, (0.0, 0.0, -0.16)), _sphere(0.055)),
            shells=(_shell('shin'), _shell('knee', 'accent')),
        ),
        (0.0, 0.0, -0.34),
        Y,
        (-0.1, 2.2),
        speed=8.0,
        effort=160.0,
        damping=8.0,
    ),
    Joint(
        'left_ankle_pitch',
        'left_shin',
        Link('left_ankle', 0.4, (_sphere(0.035),), bumps=False),
        (0.0, 0.0, -0.34),
        Y,
        (-1.0, 0.8),
        speed=8.0,
        effort=80.0,
        damping=3.0,
    ),
    Joint(
        'left_ankle_roll',
        'left_ankle',
        Link(
            'left_foot',
            1.0,
            (_box(0.22, 0.10, 0.04, (0.03, 0.0, -0.05), 'sole'),),
            shells=(_shell('foot'), _shell('sole', 'sole')),
        ),
        NOWHERE,
        X,
        (-0.5, 0.5),
        speed=8.0,
        effort=60.0,
        damping=3.0,
    ),
    Joint('left_sole_joint', 'left_foot', Link('left_sole'), (0.0, 0.0, -0.07)),
)


def _right(joint: Joint) -> Joint:
    """Return the joint of the other side, mirrored at the plane y = 0.

    A mirrored axis of roll or yaw keeps its direction, and the limits change sides. An axis along y stays as
    it is, but for two: the shoulder's points the other way (0.5 rad left is the pose of -0.5 rad right),
    and the fingers' are mirrored.
    """
    turned = joint.axis == MINUS_Y and joint.name == 'left_arm_shoulder'
    lower, upper = joint.limits
    swapped = turned or joint.axis in (X, Z)
    axis = joint.axis
    if axis is not None and (turned or joint.prismatic):
        axis = _mirrored(axis) if joint.prismatic else Y
    child = joint.child
    shapes, shells = (
        tuple(replace(shape, at=_mirrored(shape.at)) for shape in given)
        for given in (child.shapes, child.shells)
    )
    return replace(
        joint,
        name=_other(joint.name),
        parent=_other(joint.parent),
        child=replace(child, name=_other(child.name), shapes=shapes, shells=shells),
        at=_mirrored(joint.at),
        axis=axis,
        limits=(_plus_zero(-upper), _plus_zero(-lower)) if swapped else (lower, upper),
        mimics=_other(joint.mimics),
    )


def _mirrored(vector: Vector) -> Vector:
    return vector[0], _plus_zero(-vector[1]), vector[2]


def _plus_zero(number: float) -> float:
    return number + 0.0


def _other(name: str) -> str:
    return name.replace('left_', 'right_', 1) if name.startswith('left_') else name


def joints() -> Sequence[Joint]:
    right = [_right(joint) for joint in (*LEFT_ARM, *LEFT_LEG)]
    arm, leg = right[: len(LEFT_ARM)], right[len(LEFT_ARM) :]
    return [*TRUNK, *LEFT_ARM, *arm, *LEFT_LEG, *leg]


def _numbers(numbers: Iterable[float]) -> str:
    return ' '.join(f'{number:g}' for number in numbers)


def _link(link: Link) -> Iterator[str]:
    if not link.shapes:
        yield f'  <link name="{link.name}"/>'
        return
    heart = link.shapes[0]
    xx, yy, zz = heart.inertia(link.mass)
    yield f'  <link name="{link.name}">'
    yield '    <inertial>'
    yield f'      <origin xyz="{_numbers(heart.at)}"/>'
    yield f'      <mass value="{link.mass:g}"/>'
    yield f'      <inertia ixx="{xx:.6g}" ixy="0" ixz="0" iyy="{yy:.6g}" iyz="0" izz="{zz:.6g}"/>'
    yield '    </inertial>'
    for shape in link.seen:
        yield '    <visual>'
        yield f'      <origin xyz="{_numbers(shape.at)}"/>'
        yield f'      <geometry>{shape.xml()}</geometry>'
        yield f'      <material name="{shape.material}"/>'
        yield '    </visual>'
    if link.bumps:
        yield '    <collision>'
        yield f'      <origin xyz="{_numbers(heart.at)}"/>'
        yield f'      <geometry>{heart.xml()}</geometry>'
        yield '    </collision>'
    yield '  </link>'


def _joint(joint: Joint) -> Iterator[str]:
    kind = 'fixed' if joint.axis is None else 'prismatic' if joint.prismatic else 'revolute'
    yield f'  <joint name="{joint.name}" type="{kind}">'
    yield f'    <parent link="{joint.parent}"/>'
    yield f'    <child link="{joint.child.name}"/>'
    turned = f' rpy="{_numbers(joint.turned)}"' if any(joint.turned) else ''
    yield f'    <origin xyz="{_numbers(joint.at)}"{turned}/>'
    if joint.axis is not None:
        lower, upper = joint.limits
        yield f'    <axis xyz="{_numbers(joint.axis)}"/>'
        yield (
            f'    <limit lower="{lower:g}" upper="{upper:g}" '
            f'velocity="{joint.speed:g}" effort="{joint.effort:g}"/>'
        )
        yield f'    <dynamics damping="{joint.damping:g}" friction="0"/>'
    if joint.mimics:
        yield f'    <mimic joint="{joint.mimics}"/>'
    yield '  </joint>'


def urdf() -> str:
    """Return the whole description."""
    lines = [
        '<?xml version="1.0"?>',
        '<!-- Written by tools/humanoid_urdf.py: change that one, and run it. -->',
        '<robot name="humanoid">',
    ]
    for name, colour in MATERIALS.items():
        lines.append(f'  <material name="{name}"><color rgba="{_numbers(colour)} 1"/></material>')
    lines += ['', *_link(PELVIS)]
    for joint in joints():
        lines += ['', *_joint(joint), *_link(joint.child)]
    return '\n'.join([*lines, '</robot>', ''])


def main() -> int:
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    TARGET.write_text(urdf(), encoding='utf-8')
    print(TARGET)
    return 0


if __name__ == '__main__':
    sys.exit(main())
