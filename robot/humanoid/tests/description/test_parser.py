"""The parser of descriptions: what it refuses, and where it puts the links."""

from __future__ import annotations

import random
from collections.abc import Sequence
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from pytransform3d.rotations import matrix_from_quaternion
from pytransform3d.urdf import UrdfTransformManager

from humanoid.description import urdf_text
from humanoid.urdf import BadDescription, Description, Transform, parse

LINKS = '<link name="a"/><link name="b"/><link name="c"/>'
HINGE = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>{}</joint>'
LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="3"/>'
FIXED = '<joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint>'


def robot(body: str) -> str:
    return f'<robot name="r">{body}</robot>'


def matrix(where: Transform) -> np.ndarray:
    x, y, z, w = where.rotation
    found = np.eye(4)
    found[:3, :3] = matrix_from_quaternion([w, x, y, z])
    found[:3, 3] = where.translation
    return found


def crooked(rng: random.Random, count: int = 12) -> str:
    """A random tree with every kind of joint that moves, every origin and axis askew."""

    def three(scale: float) -> str:
        return ' '.join(f'{rng.uniform(-scale, scale):.6f}' for _ in range(3))

    parts = [f'<link name="l{number}"/>' for number in range(count)]
    for number in range(1, count):
        kind = ('revolute', 'continuous', 'prismatic', 'fixed')[number % 4]
        parts.append(
            f'<joint name="j{number}" type="{kind}"><parent link="l{rng.randrange(number)}"/>'
            f'<child link="l{number}"/><origin xyz="{three(1.0)}" rpy="{three(3.0)}"/>'
            f'<axis xyz="{three(1.0)}"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>'
        )
    return robot(''.join(parts))


def compare(text: str, description: Description, rng: random.Random, poses: int) -> None:
    independent = UrdfTransformManager()
    independent.load_urdf(text)
    for _ in range(poses):
        given = {
            name: rng.uniform(max(joint.lower, -3.0), min(joint.upper, 3.0))
            for name, joint in description.joints.items()
            if joint.moves and joint.mimic is None
        }
        for name, position in description.positions(given).items():
            independent.set_joint(name, position)
        for link in description.links:
            theirs = independent.get_transform(link, description.root)
            assert matrix(description.pose(link, given)) == pytest.approx(theirs, abs=1e-9)


def test_poses_of_the_humanoid_are_those_of_an_independent_library() -> None:
    text = urdf_text()
    compare(text, parse(text), random.Random(1), poses=5)


@pytest.mark.parametrize('seed', range(5))
def test_poses_of_crooked_trees_are_those_of_an_independent_library(seed: int) -> None:
    rng = random.Random(seed)
    text = crooked(rng)
    compare(text, parse(text), rng, poses=5)


def test_a_mimic_follows_another_mimic() -> None:
    description = parse(robot(
        '<link name="a"/><link name="b"/><link name="c"/><link name="d"/>'
        + ''.join(
            f'<joint name="{name}" type="continuous"><parent link="a"/><child link="{child}"/>{mimic}</joint>'
            for name, child, mimic in (
                ('x', 'b', ''),
                ('y', 'c', '<mimic joint="x" multiplier="2" offset="0.5"/>'),
                ('z', 'd', '<mimic joint="y" multiplier="-3"/>'),
            )
        )
    ))  # fmt: skip
    assert description.positions({'x': 1.0}) == {'x': 1.0, 'y': 2.5, 'z': -7.5}
    assert description.positions({}) == {}


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('', 'it is not XML'),
        ('<robot name="r">', 'it is not XML'),
        ('<model/>', 'its root is <model>, not <robot>'),
        (robot(''), 'it has no <link>'),
        (robot('<link/>'), 'a <link> has no name'),
        (robot('<link name="a"/><link name="a"/>'), "two links are named 'a'"),
        (robot(LINKS), 'it needs one link at the root, and has 3: a, b, c'),
        (robot(LINKS + HINGE.format('')), "joint 'j': a revolute joint needs a <limit>"),
        (robot(LINKS + HINGE.format(LIMIT) + HINGE.format(LIMIT)), "two joints are named 'j'"),
        (robot(LINKS + HINGE.format(LIMIT.replace('-1', '5'))), 'its lower limit 5 is above the upper one 1'),
        (robot(LINKS + HINGE.format(LIMIT.replace('-1', 'nan'))), "joint 'j': lower is 'nan', not a number"),
        (robot(LINKS + HINGE.format(LIMIT.replace('-1', '1e999'))), "lower is '1e999', not a number"),
        (robot(LINKS + HINGE.format(LIMIT + '<axis xyz="0 0 0"/>')), 'its axis has no direction'),
        (robot(LINKS + HINGE.format(LIMIT + '<origin xyz="0 0"/>')), 'xyz has 2 numbers, not 3'),
        (robot(LINKS + HINGE.format(LIMIT).replace('revolute', 'ball')), "its type is 'ball', not one of"),
        (robot('<link name="a"/>' + HINGE.format(LIMIT)), "names the link 'b': there is none"),
        (robot(LINKS + HINGE.format(LIMIT + '<mimic joint="x"/>') + FIXED), "mimics 'x', which is not there"),
        (robot(LINKS + HINGE.format(LIMIT + '<mimic joint="j"/>') + FIXED), "joint 'j' mimics itself"),
        (
            robot(LINKS + FIXED + FIXED.replace('"k"', '"l"').replace('"b"', '"a"')),
            "the link 'c' hangs on two joints",
        ),
        (
            robot(LINKS + FIXED + FIXED.replace('"k"', '"l"').replace('"b"', '"d"').replace('"c"', '"b"')
                  .replace('"d"', '"c"')),
            'some of its joints go in a circle',
        ),
    ],
)  # fmt: skip
def test_what_is_no_description_is_refused_with_the_reason(text: str, reason: str) -> None:
    with pytest.raises(BadDescription) as refused:
        parse(text)
    assert reason in str(refused.value)


@pytest.mark.parametrize(
    'doctype',
    [
        '<!DOCTYPE robot>',
        '<!DOCTYPE robot SYSTEM "file:///etc/passwd">',
        '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>',
    ],
)
def test_a_document_type_is_refused_before_any_entity_is_read(doctype: str) -> None:
    with pytest.raises(BadDescription, match='document type'):
        parse(f'<?xml version="1.0"?>{doctype}<robot name="r"><link name="&b;"/></robot>')


def test_a_description_of_a_long_chain_is_read() -> None:
    count = 5000
    text = robot(
        ''.join(f'<link name="l{number}"/>' for number in range(count))
        + ''.join(
            f'<joint name="j{number}" type="fixed"><parent link="l{number}"/>'
            f'<child link="l{number + 1}"/></joint>'
            for number in range(count - 1)
        )
    )
    assert parse(text).root == 'l0'


def test_the_tree_is_that_of_the_file() -> None:
    file, read = ET.fromstring(urdf_text()), parse(urdf_text())
    named: Sequence[str | None] = [joint.get('name') for joint in file.findall('joint')]
    assert list(read.joints) == named
    assert read.root == 'base_link'
