"""Links and joints of a URDF: what is read, where positions put the links, and what is refused."""

from __future__ import annotations

import itertools
import math
import random

import pytest
from helpers.robot import ROOT
from pytransform3d.rotations import matrix_from_quaternion
from pytransform3d.urdf import UrdfTransformManager

from goalwire.transforms.rigid import IDENTITY, Rigid
from goalwire.transforms.urdf import Kinematics, UrdfError, read_kinematics

TWO_ARMS = (ROOT / 'tests' / 'data' / 'robot.urdf').read_text(encoding='utf-8')
HUMANOID = (ROOT / 'robot' / 'humanoid_description' / 'urdf' / 'humanoid.urdf').read_text(encoding='utf-8')
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def chain(*joints: str, links: str = 'abc') -> str:
    return f'<robot name="r">{"".join(f"<link name={link!r}/>" for link in links)}{"".join(joints)}</robot>'


def joint(name: str, parent: str, child: str, inner: str = '', kind: str = 'continuous') -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inner}</joint>'
    )


def test_joints_come_a_limb_at_a_time() -> None:
    links = ['body', 'arm', 'leg', 'hand', 'foot']
    pairs = [('body', 'arm'), ('body', 'leg'), ('arm', 'hand'), ('leg', 'foot')]
    text = ''.join([f'<link name="{name}"/>' for name in links] + [joint(b, a, b) for a, b in pairs])
    model = read_kinematics(f'<robot name="r">{text}</robot>')
    assert [each.name for each in model.joints] == ['arm', 'hand', 'leg', 'foot']


def test_joints_turn_and_slide_their_links() -> None:
    model = read_kinematics(TWO_ARMS)
    poses = model.poses({'left_joint': math.pi / 2, 'head_joint': math.pi / 2, 'slide_joint': 0.3}, {})
    assert poses['left_arm'].apply((1.0, 0.0, 0.0)) == pytest.approx((0.0, 0.1, -0.1))  # about y, downwards
    assert poses['slide'].translation == pytest.approx((0.0, 0.3, 1.1))  # along the head's x
    turned = poses['right_arm'].rotation[1]
    assert turned == pytest.approx(math.sin((0.1 - math.pi / 2) / 2))  # it mimics the left one
    assert model.poses({'left_joint': math.nan}, {})['left_arm'].rotation == UPRIGHT


def test_a_frame_that_is_published_counts_before_a_joint() -> None:
    model = read_kinematics(TWO_ARMS)
    frames = {'head': ('mast', Rigid((0.0, 0.0, 2.0), UPRIGHT)), 'slide': ('elsewhere', IDENTITY)}
    poses = model.poses({'slide_joint': 0.2}, frames)
    assert poses['head'].translation == pytest.approx((0.0, 0.0, 2.4))
    assert poses['slide'].translation == pytest.approx((0.2, 0.0, 2.4))


def test_frames_with_a_prefix_are_those_of_the_links_after_it() -> None:
    model = read_kinematics(TWO_ARMS)
    high = Rigid((0.0, 0.0, 2.0), UPRIGHT)
    frames = {'alice/head': ('alice/mast', high), 'bob/head': ('bob/mast', IDENTITY)}
    assert model.poses({}, frames, 'alice/')['head'].translation == pytest.approx((0.0, 0.0, 2.4))
    assert model.poses({}, frames, 'bob/')['head'].translation == pytest.approx((0.0, 0.0, 0.4))


def test_a_joint_follows_through_another_one_unless_its_own_position_is_given() -> None:
    model = read_kinematics(
        chain(
            joint('lead', 'a', 'b'),
            joint('middle', 'b', 'c', '<mimic joint="lead" multiplier="2" offset="1"/>'),
            joint('last', 'c', 'd', '<mimic joint="middle" multiplier="-1" offset="0.5"/>'),
            links='abcd',
        )
    )
    assert model.positions({'lead': 3.0}) == {'lead': 3.0, 'middle': 7.0, 'last': -6.5}
    assert model.positions({'lead': 3.0, 'middle': 0.0}) == {'lead': 3.0, 'middle': 0.0, 'last': 0.5}
    assert model.positions({'other': 1.0}) == {'other': 1.0}


def test_a_humanoids_links_lie_where_an_independent_library_puts_them() -> None:
    model, rng = read_kinematics(HUMANOID), random.Random(16)
    independent = UrdfTransformManager()
    independent.load_urdf(HUMANOID)
    for _ in range(10):
        free = {each.name: rng.uniform(each.lower, each.upper) for each in model.joints if each.is_free}
        for name, position in model.positions(free).items():
            independent.set_joint(name, position)
        for link, pose in model.poses(free, {}).items():
            matrix = independent.get_transform(link, model.root)
            x, y, z, w = pose.rotation
            assert matrix[:3, :3] == pytest.approx(matrix_from_quaternion([w, x, y, z]), abs=1e-9)
            assert matrix[:3, 3] == pytest.approx(pose.translation, abs=1e-9)


def test_limits_are_those_of_the_joint_and_of_its_safety_controller() -> None:
    inner = '<limit lower="-1" upper="2"/><safety_controller soft_upper_limit="1.5" k_velocity="1"/>'
    [found] = read_kinematics(chain(joint('j', 'a', 'b', inner, 'revolute'), links='ab')).joints
    assert (found.lower, found.upper, found.soft_lower, found.soft_upper) == (-1.0, 2.0, -math.inf, 1.5)


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        (' ', 'the URDF is empty'),
        ('<robot', 'cannot be read as XML'),
        ('<sdf/>', 'not a URDF: it begins with <sdf>'),
        ('<robot/>', '0 links'),
        ('<robot><link/></robot>', 'a <link> has no name'),
        (chain(links='aa'), "two links have the name 'a'"),
        (chain(links='ab'), '2 root links, and needs one: a, b'),
        (chain(joint('j', 'a', 'x'), links='a'), "joins the link 'x'"),
        (chain(joint('j', 'a', 'b'), joint('j', 'a', 'c')), "two joints have the name 'j'"),
        (chain(joint('j', 'a', 'c'), joint('k', 'b', 'c')), '2 root links'),
        (chain(joint('j', 'b', 'c'), joint('k', 'c', 'b')), 'in a circle'),
        (chain(joint('j', 'a', 'b', kind='hinge'), links='ab'), "the type of the joint 'j' is 'hinge'"),
        (chain(joint('j', 'a', 'b', kind='revolute'), links='ab'), 'needs a <limit>'),
        (chain(joint('j', 'a', 'b', '<axis xyz="0 0 0"/>'), links='ab'), 'its axis has no direction'),
        (chain(joint('j', 'a', 'b', '<axis xyz="0 x 0"/>'), links='ab'), "a number is needed, not 'x'"),
        (chain(joint('j', 'a', 'b', '<origin xyz="1 2"/>'), links='ab'), 'three numbers are needed'),
        (chain(joint('j', 'a', 'b', '<origin xyz="1 2 inf"/>'), links='ab'), 'not finite'),
        (chain(joint('j', 'a', 'b', '<mimic joint="x"/>'), links='ab'), "mimics 'x', which is unknown"),
        (chain(joint('j', 'a', 'b', '<mimic joint="j"/>'), links='ab'), 'mimics itself'),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot>&a;</robot>', 'document type'),
        ('x' * (17 << 20), 'too many'),
    ],
    ids=lambda given: given[:20],
)
def test_a_description_without_a_tree_is_refused(text: str, problem: str) -> None:
    with pytest.raises(UrdfError, match=problem):
        read_kinematics(text)


def test_a_deep_robot_is_read_without_recursion() -> None:
    links = [f'l{number}' for number in range(1500)]
    text = ''.join(f'<link name="{link}"/>' for link in links)
    text += ''.join(joint(f'to_{b}', a, b, kind='fixed') for a, b in itertools.pairwise(links))
    model: Kinematics = read_kinematics(f'<robot name="r">{text}</robot>')
    assert len(model.poses({}, {})) == 1500
