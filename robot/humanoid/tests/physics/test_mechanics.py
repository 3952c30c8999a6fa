"""The motion of the simulated body, against formulas and against the frames of another library."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from pytransform3d.urdf import UrdfTransformManager

from humanoid.description import urdf_text
from humanoid.physics.build import GRAVITY, ROTOR_INERTIA, Robot, build
from humanoid.physics.world import World

Matrix = NDArray[np.float64]
SHOULDER = 'left_arm_shoulder'
RIGID = 1e6  # kg·m² and kg: what has such a rotor does not move


@pytest.fixture
def robot() -> Robot:
    return build(urdf_text())


def frames(positions: dict[str, float] | None = None) -> UrdfTransformManager:
    """Where the links are, by pytransform3d; mimics are given their positions by the caller."""
    manager = UrdfTransformManager()
    manager.load_urdf(urdf_text())
    for name, position in (positions or {}).items():
        manager.set_joint(name, position)
    return manager


def below(joint: str) -> Sequence[str]:
    """The links that hang on a joint."""
    tree: dict[str, list[str]] = {}
    start = ''
    for element in ET.fromstring(urdf_text()).findall('joint'):
        parent, child = element.find('parent'), element.find('child')
        assert parent is not None
        assert child is not None
        tree.setdefault(parent.get('link', ''), []).append(child.get('link', ''))
        if element.get('name') == joint:
            start = child.get('link', '')
    found = [start]
    for link in found:
        found += tree.get(link, [])
    return found


def masses(links: Sequence[str], manager: UrdfTransformManager) -> Iterator[tuple[float, Matrix, Matrix]]:
    """Mass (kg), centre (m) and inertia about it (kg·m²) of each link, in the pelvis' frame."""
    for link in ET.fromstring(urdf_text()).findall('link'):
        inertial = link.find('inertial')
        if link.get('name') not in links or inertial is None:
            continue
        origin, mass, inertia = (inertial.find(tag) for tag in ('origin', 'mass', 'inertia'))
        assert origin is not None
        assert mass is not None
        assert inertia is not None
        assert 'rpy' not in origin.keys()  # noqa: SIM118 - an element, not a mapping
        pose = manager.get_transform(link.get('name'), 'base_link')
        centre = pose @ [*map(float, origin.get('xyz', '').split()), 1.0]
        xx, xy, xz, yy, yz, zz = (
            float(inertia.get(f'i{axes}', '')) for axes in ('xx', 'xy', 'xz', 'yy', 'yz', 'zz')
        )
        own = pose[:3, :3] @ [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] @ pose[:3, :3].T
        yield float(mass.get('value', '')), centre[:3], own


def test_every_motor_is_as_strong_as_the_description_says(robot: Robot) -> None:
    efforts = {
        joint.get('name'): float(limit.get('effort', ''))
        for joint in ET.fromstring(urdf_text()).findall('joint')
        if (limit := joint.find('limit')) is not None and joint.find('mimic') is None
    }
    assert len(efforts) == len(robot.motors) == 31
    for name, effort in efforts.items():
        assert robot.model.actuator(name).forcerange.tolist() == [-effort, effort]


def test_links_are_where_another_library_has_them(robot: Robot) -> None:
    chance = np.random.default_rng(7)
    mimics = {
        joint.get('name'): mimic.get('joint', '')
        for joint in ET.fromstring(urdf_text()).findall('joint')
        if (mimic := joint.find('mimic')) is not None
    }
    data = mujoco.MjData(robot.model)
    manager = frames()
    links = [link.get('name', '') for link in ET.fromstring(urdf_text()).findall('link')]
    for _ in range(10):
        drawn = {
            name: chance.uniform(*robot.model.joint(name).range) for name in robot.names if name not in mimics
        }
        drawn |= {name or '': drawn[leader] for name, leader in mimics.items()}
        for name, position in drawn.items():
            manager.set_joint(name, position)
            data.joint(name).qpos = position
        mujoco.mj_kinematics(robot.model, data)
        for link in links:
            pose = manager.get_transform(link, 'base_link')
            assert data.body(link).xpos == pytest.approx(pose[:3, 3], abs=1e-9)
            assert data.body(link).xmat.reshape(3, 3) == pytest.approx(pose[:3, :3], abs=1e-9)


def test_a_free_arm_swings_with_the_period_of_a_compound_pendulum(robot: Robot) -> None:
    model = robot.model
    shoulder = model.joint(SHOULDER)
    model.dof_armature[:] = RIGID
    model.dof_armature[shoulder.dofadr] = ROTOR_INERTIA
    model.dof_damping[:] = 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION | mujoco.mjtDisableBit.mjDSBL_CONTACT
    manager = frames()
    pivot = manager.get_transform('left_shoulder', 'base_link')[:3, 3]
    about_axis, moment = ROTOR_INERTIA, np.zeros(3)
    for mass, centre, inertia in masses(below(SHOULDER), manager):
        lever = centre - pivot
        about_axis += inertia[1, 1] + mass * (lever[0] ** 2 + lever[2] ** 2)
        moment += mass * lever
    expected = math.tau * math.sqrt(about_axis / (GRAVITY * math.hypot(moment[0], moment[2])))
    hangs = -math.atan2(moment[0], -moment[2])  # its axis points to the right

    data = mujoco.MjData(model)
    data.joint(SHOULDER).qpos = hangs + 0.05
    crossings: list[float] = []
    before = 0.05
    while len(crossings) < 11:
        mujoco.mj_step(model, data)
        off = float(data.joint(SHOULDER).qpos[0]) - hangs
        if off * before < 0.0:
            crossings.append(data.time - model.opt.timestep * off / (off - before))
        before = off
    assert (crossings[-1] - crossings[0]) / 5.0 == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize('angle', [0.4, 1.0, math.pi / 2])
def test_a_lifted_arm_needs_the_torque_of_its_weight(body: World, angle: float) -> None:
    body.limit_speed(SHOULDER, 2.0)
    body.aim(SHOULDER, angle)
    for _ in range(250):
        body.tick()
    positions = {name: body.joint(name)[0] for name in body.robot.names}
    position, speed, torque = body.joint(SHOULDER)
    assert (position, speed) == pytest.approx((angle, 0.0), abs=2e-3)
    manager = frames(positions)
    pivot = manager.get_transform('left_shoulder', 'base_link')[:3, 3]
    turning = sum(
        mass * GRAVITY * (centre - pivot)[0] for mass, centre, _ in masses(below(SHOULDER), manager)
    )
    assert torque == pytest.approx(turning, rel=0.01)
    assert turning > 1.0


def test_a_load_beyond_its_torque_pulls_the_arm_down(body: World) -> None:
    body.robot.model.body('left_hand').mass[:] = 60.0  # the shoulder has 40 N·m
    body.aim(SHOULDER, math.pi / 2)
    for _ in range(300):
        body.tick()
        assert abs(body.joint(SHOULDER)[2]) <= 40.0 + 1e-9
    assert body.joint(SHOULDER)[0] < 1.0
