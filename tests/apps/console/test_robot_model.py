"""A robot's shapes, where its joints and frames put them, and what a description may not do."""

from __future__ import annotations

import math
from time import monotonic
from types import SimpleNamespace
from typing import Any

import pytest
from helpers.console import DATA

from goalwire.apps.console.state.form_model import form_of
from goalwire.apps.console.state.robot_model import as_scene, likely_prefix, read_urdf, root_pose
from goalwire.apps.console.state.robot_state import RobotState
from goalwire.apps.console.state.robot_watch import (
    RobotWatch,
    find_place,
    namespaces,
    navigation_target,
    place_values,
)
from goalwire.errors import RemoteError
from goalwire.transforms.rigid import IDENTITY, Rigid

URDF = (DATA / 'robot.urdf').read_text(encoding='utf-8')
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
LEFT = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))  # by 90°


def test_links_and_shapes_are_read() -> None:
    model = read_urdf(URDF)
    assert model.kinematics.name == 'two_arms'
    assert (model.kinematics.root, len(model.kinematics.links)) == ('base_link', 6)
    assert [joint.name for joint in model.kinematics.joints if joint.is_free] == [
        'left_joint',
        'head_joint',
        'slide_joint',
    ]
    shapes = {visual.link: (visual.kind, visual.size, visual.colour) for visual in model.visuals}
    assert shapes['base_link'] == ('box', (0.5, 0.4, 0.3), (0.15, 0.4, 0.85, 1.0))
    assert shapes['left_arm'][2] == (0.95, 0.5, 0.1, 1.0)
    assert shapes['head'][:2] == ('sphere', (0.12,))
    assert {each['link'] for each in as_scene(model, {})} == {
        'base_link',
        'mast',
        'left_arm',
        'right_arm',
        'head',
    }


def test_the_root_hangs_on_the_topmost_frame_and_circles_end() -> None:
    one = Rigid((1.0, 0.0, 0.0), UPRIGHT)
    frames = {'base_link': ('odom', one), 'odom': ('map', one)}
    assert root_pose('base_link', frames) == ('map', Rigid((2.0, 0.0, 0.0), UPRIGHT))
    assert root_pose('base_link', frames | {'map': ('base_link', one)})[0] == 'map'


@pytest.mark.parametrize(
    ('children', 'namespace', 'prefix'),
    [
        (['alice/base_link', 'bob/base_link'], '/alice', 'alice/'),
        (['alice/base_link', 'base_link'], '/alice', 'alice/'),
        (['alice/base_link', 'base_link'], '', ''),
        (['base_link'], '/alice', ''),
        (['r1/base_link'], '/alice', ''),
        (['r1/base_link'], '', 'r1/'),
        (['r1/base_link', 'r2/base_link'], '/alice', ''),
        (['my_base_link', 'notbase_link'], '', 'my_'),
        ([], '/alice', ''),
    ],
)
def test_a_prefix_is_guessed_from_the_frames_and_the_namespace(
    children: list[str], namespace: str, prefix: str
) -> None:
    frames = dict.fromkeys(children, ('map', IDENTITY))
    assert likely_prefix(read_urdf(URDF), frames, namespace) == prefix


_BOX = '<link name="a"><visual><geometry><box size="{}"/></geometry></visual></link>'


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        ('<robot', 'cannot be read as XML'),
        ('<sdf/>', 'not a URDF'),
        ('<robot><link name="a"/><link name="b"/></robot>', '2 root links'),
        (f'<robot>{_BOX.format("1 x 1")}</robot>', 'number'),
        (f'<robot>{_BOX.format("1 inf 1")}</robot>', 'finite'),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot>&a;</robot>', 'document type'),
        ('x' * (17 << 20), 'too many'),
    ],
    ids=lambda given: given[:20],
)
def test_a_description_that_is_none_is_told(text: str, problem: str) -> None:
    with pytest.raises(RemoteError, match=problem):
        read_urdf(text)


_SHELL = """
<robot name="r"><link name="arm">
  <visual><geometry><mesh filename="package://arm/arm.stl"/></geometry></visual>
  <visual><geometry><mesh filename="package://arm/panel.stl"/></geometry></visual>
  <visual><geometry><sphere radius="0.1"/></geometry></visual>
  <collision><geometry><box size="1 2 3"/></geometry></collision>
</link></robot>"""


def test_a_body_stands_for_a_mesh_that_is_missing() -> None:
    model = read_urdf(_SHELL)
    assert [each['kind'] for each in as_scene(model, {})] == ['sphere', 'box']
    urls = {'package://arm/arm.stl': '/a', 'package://arm/panel.stl': '/b'}
    assert [each['kind'] for each in as_scene(model, urls)] == ['mesh', 'mesh', 'sphere']


def frame(parent: str, child: str, x: float, w: float = 1.0) -> Any:
    vector = SimpleNamespace(x=x, y=0.0, z=0.0)
    turn = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=w)
    transform = SimpleNamespace(translation=vector, rotation=turn)
    return SimpleNamespace(header=SimpleNamespace(frame_id=parent), child_frame_id=child, transform=transform)


def test_a_robot_is_put_together_from_what_comes() -> None:
    watch = RobotState('')
    watch.take_description(SimpleNamespace(data=URDF), 0.0)
    watch.take_joints(SimpleNamespace(name=['left_joint'], position=[0.5]), 0.0)
    for step in range(10):
        watch.take_frames(SimpleNamespace(transforms=[frame('odom', 'base_link', step / 10)]), 0.0)
    watch.take_frames(SimpleNamespace(transforms=[frame('odom', 'base_link', math.nan)]), 0.0)
    watch.take_frames(SimpleNamespace(transforms=[frame('odom', 'base_link', 5.0, w=0.0)]), 0.0)
    poses = dict(watch.link_poses())
    assert watch.pose()[0] == 'odom'
    assert poses['base_link'] == [0.9, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    assert poses['left_arm'][4] == pytest.approx(math.sin(0.25), abs=1e-4)
    assert len(watch.trail) == 10


def test_a_description_that_cannot_be_read_takes_none_away() -> None:
    watch = RobotState('')
    watch.take_description(SimpleNamespace(data='<sdf/>'), 0.0)
    assert (watch.model, watch.link_poses()) == (None, [])
    assert 'not a URDF' in watch.problem
    watch.take_description(SimpleNamespace(data=URDF), 0.0)
    model = watch.model
    assert watch.problem == ''
    assert model is not None
    watch.take_description(SimpleNamespace(data='<robot'), 0.0)
    assert watch.model is model
    assert watch.link_poses()
    assert 'cannot be read as XML' in watch.problem
    assert 'the one before is shown' in watch.problem


def test_what_was_said_before_does_not_make_a_robot_live() -> None:
    watch = RobotWatch(None, None, '')  # type: ignore[arg-type] # it subscribes when it looks
    assert not watch.is_fresh
    static = SimpleNamespace(transforms=[frame('base_link', 'camera', 0.1)])
    watch.take_static_frames(static, monotonic())
    assert watch.frames['camera'][0] == 'base_link'
    assert not watch.is_fresh, 'they may have been published hours ago'
    watch.take_frames(SimpleNamespace(transforms=[frame('odom', 'base_link', 0.1)]), monotonic())
    assert watch.is_fresh


def test_frames_of_another_robot_are_no_news_of_this_one() -> None:
    watch = RobotWatch(None, None, '/alice')  # type: ignore[arg-type] # it subscribes when it looks
    watch.take_description(SimpleNamespace(data=URDF), 0.0)
    watch.take_frames(SimpleNamespace(transforms=[frame('map', 'bob/base_link', 2.0)]), 4.0)
    assert list(watch.trail) == [], 'it is not known where this one is'
    watch.take_frames(SimpleNamespace(transforms=[frame('map', 'alice/base_link', 1.0)]), 5.0)
    watch.take_frames(SimpleNamespace(transforms=[frame('map', 'bob/base_link', 2.0)]), 9.0)
    assert watch.moved_at == 5.0
    assert watch.pose()[1].translation == (1.0, 0.0, 0.0)


# -- what a robot offers -------------------------------------------------------------------------------------


def test_robots_are_found_by_their_descriptions() -> None:
    text, joints = ['std_msgs/msg/String'], ['sensor_msgs/msg/JointState']
    assert namespaces([('/robot_description', text), ('/a/robot_description', text)]) == ['', '/a']
    assert namespaces([('/b/joint_states', joints)]) == ['/b']
    assert namespaces([('/chatter', text)]) == []


def test_goals_with_a_place_can_be_navigated_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_INTERFACE_PATH', str(DATA))
    flat = navigation_target(
        '/go', 'console_interfaces/action/GoTo', form_of('console_interfaces/action/GoTo_Goal')
    )
    assert flat is not None
    assert place_values(flat, {'speed': 1.0}, 'odom', 1.0, 2.0, 0.0) == {'speed': 1.0, 'x': 1.0, 'y': 2.0}
    fields = form_of('geometry_msgs/msg/PoseWithCovarianceStamped')
    assert navigation_target('/no', 'x', fields) is None
    nested = form_of('nav_msgs/srv/GetPlan_Request')
    assert navigation_target('/plan', 'nav2_msgs/action/ComputePathToPose', nested) is None
    pose = navigation_target('/plan', 'x', nested)
    assert pose is not None
    values = place_values(pose, {}, 'map', 1.0, 2.0, math.pi)
    assert values['start']['header'] == {'stamp': 'now', 'frame_id': 'map'}
    assert values['start']['pose']['orientation']['z'] == pytest.approx(1.0)


def test_a_goal_in_another_frame_is_marked_where_that_frame_puts_it() -> None:
    target = navigation_target('/go', 'x', form_of('nav_msgs/srv/GetPlan_Request'))
    assert target is not None
    frames = {
        'odom': ('map', Rigid((1.0, 0.0, 0.0), UPRIGHT)),
        'base': ('odom', Rigid((0.0, 2.0, 0.5), LEFT)),
    }

    def find(frame: str) -> Any:
        return find_place(target, place_values(target, {}, frame, 3.0, 0.0, 0.5), 'map', frames)

    assert find('base') == pytest.approx((1.0, 5.0, math.pi / 2 + 0.5))
    assert find('/odom') == pytest.approx((4.0, 0.0, 0.5))
    assert find('map') == find('') == pytest.approx((3.0, 0.0, 0.5))
    assert find('elsewhere') is None
    no_turn = place_values(target, {}, 'base', 3.0, 0.0, 0.0)
    no_turn['start']['pose']['orientation'] = dict.fromkeys('xyzw', 0.0)
    assert find_place(target, no_turn, 'map', frames) == pytest.approx((1.0, 5.0, math.pi / 2))
