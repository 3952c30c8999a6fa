"""The humanoid's description: what physics engines and other parsers make of it."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from pytransform3d.urdf import UrdfTransformManager
from tools.humanoid_urdf import urdf

from humanoid.description import urdf_path, urdf_text
from humanoid.model import JOINTS

AXES = {
    'left_arm_shoulder': '0 -1 0',
    'right_arm_shoulder': '0 1 0',
    'left_arm_elbow': '0 -1 0',
    'right_arm_elbow': '0 -1 0',
    'left_knee': '0 1 0',
    'right_knee': '0 1 0',
}


@pytest.fixture(scope='module')
def body() -> ET.Element:
    return ET.fromstring(urdf_text())


@pytest.fixture
def physics() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(urdf_path()))


def numbers(text: str | None) -> list[float]:
    return [float(number) for number in (text or '').split()]


def test_the_file_is_what_its_generator_writes() -> None:
    assert urdf_path().read_text(encoding='utf-8') == urdf(), 'run tools/humanoid_urdf.py'


def test_it_is_one_tree_below_the_pelvis_with_31_motors(body: ET.Element) -> None:
    links = {link.get('name') for link in body.iter('link')}
    joints = body.findall('joint')
    children = [joint.find('child').get('link') for joint in joints]  # type: ignore[union-attr]
    assert len(children) == len(set(children)) == len(links) - 1
    assert links - set(children) == {'base_link'}
    motors = [joint for joint in joints if joint.get('type') != 'fixed' and joint.find('mimic') is None]
    assert len(motors) == 31


def test_the_chapters_joints_keep_their_names_axes_and_limits(body: ET.Element) -> None:
    axes = {joint.get('name'): joint.find('axis') for joint in body.findall('joint')}
    for name, axis in AXES.items():
        found = axes[name]
        assert found is not None
        assert found.get('xyz') == axis
    limits = {joint.get('name'): joint.find('limit') for joint in body.findall('joint')}
    for spec in JOINTS:
        limit = limits[spec.name]
        assert limit is not None
        bounds = [float(limit.get(each, 'nan')) for each in ('lower', 'upper', 'velocity')]
        assert bounds == [spec.lower, spec.upper, spec.max_velocity]


def test_every_mass_has_an_inertia_that_a_body_can_have(body: ET.Element) -> None:
    total = 0.0
    for inertial in body.iter('inertial'):
        inertia, mass = inertial.find('inertia'), inertial.find('mass')
        assert inertia is not None
        assert mass is not None
        total += float(mass.get('value', 'nan'))
        xx, xy, xz, yy, yz, zz = (float(inertia.get(f'i{axes}', 'nan')) for axes in
                                  ('xx', 'xy', 'xz', 'yy', 'yz', 'zz'))  # fmt: skip
        a, b, c = sorted(np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        assert a > 0.0
        assert c <= a + b
    assert total == pytest.approx(50.0)


def test_mujoco_takes_it_and_nothing_runs_into_itself_at_home(physics: mujoco.MjModel) -> None:
    data = mujoco.MjData(physics)
    assert (physics.nq, physics.nbody) == (33, 34)  # two fingers mimic
    mujoco.mj_forward(physics, data)
    assert data.ncon == 0
    for spec in JOINTS:
        data.joint(spec.name).qpos = spec.home
    mujoco.mj_forward(physics, data)
    assert data.ncon == 0


def test_it_stands_with_its_soles_on_the_floor_and_is_as_high_as_a_youth() -> None:
    frames = UrdfTransformManager()
    frames.load_urdf(urdf_text())
    for sole in ('left_sole', 'right_sole'):
        assert frames.get_transform(sole, 'base_footprint')[2, 3] == pytest.approx(0.0)
    head = frames.get_transform('head', 'base_footprint')[2, 3]
    assert head + 0.185 == pytest.approx(1.5, abs=0.05)
