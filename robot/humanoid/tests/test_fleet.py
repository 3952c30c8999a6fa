"""Several robots in one domain: namespaces, frames and colours of their own."""

from __future__ import annotations

import re

import pytest
from helpers.collector import Collector
from helpers.processes import Program
from helpers.robot import humanoid, robot_client
from helpers.wires import DDS
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from humanoid.description import urdf_text
from humanoid.fleet import BadName, coloured, fleet
from humanoid.urdf import parse

WHOLE = '10 of 10 steps ended as they should'
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.mark.parametrize(
    'names', [[''], ['a b'], ['1a'], ['a/b'], ['é'], ['a' * 41], ['bob', 'alice', 'bob']]
)
def test_a_name_that_is_no_namespace_or_is_taken_is_refused(names: list[str]) -> None:
    with pytest.raises(BadName, match='called'):
        fleet(names)


def test_without_names_there_is_one_robot_as_ever() -> None:
    [robot] = fleet([])
    assert robot.label('battery_service') == 'battery_service'


def test_each_robot_has_colours_of_its_own() -> None:
    texts = {coloured(urdf_text(), number) for number in range(5)}
    assert len(texts) == 5
    assert coloured(urdf_text(), 0) in {urdf_text(), coloured(urdf_text(), 5)}
    assert {len(parse(text).joints) for text in texts} == {len(parse(urdf_text()).joints)}


def test_a_bad_name_is_told_in_a_line(world: dict[str, str]) -> None:
    with humanoid('up', '--name', 'a b', env=world) as program:
        assert program.wait() == 1
    assert (
        program.output
        == "humanoid: a robot cannot be called 'a b': use letters, digits and _, a letter first"
    )


@pytest.mark.long
@pytest.mark.timeout(400)
@pytest.mark.parametrize(('network', 'body'), [('rmw_zenoh_cpp', '--no-physics'), (DDS, '--physics')])
def test_two_robots_carry_out_their_missions_at_once(world: dict[str, str], body: str) -> None:
    if body == '--physics':
        pytest.importorskip('mujoco', reason='the physics is MuJoCo')
    names = ('alice', 'bob')
    with humanoid('up', body, '--name', names[0], '--name', names[1], env=world) as up:
        assert isinstance(up, Program)
        for _ in range(2 * 5):
            up.expect(r'\[(alice|bob)/\w+\] .*((Service|Server) ready|Robot initialized)')
        with robot_client() as client:
            fixed: Collector[TFMessage] = Collector()
            moving: Collector[TFMessage] = Collector()
            texts: Collector[String] = Collector()
            client.node.create_subscription(TFMessage, '/tf_static', fixed, LATCHED)
            client.node.create_subscription(TFMessage, '/tf', moving, 100)
            for name in names:
                client.node.create_subscription(String, f'/{name}/robot_description', texts, LATCHED)
            told = {each.data for each in texts.expect(2)}
            assert told == {coloured(urdf_text(), number) for number in range(2)}
            seen: set[tuple[str, str]] = set()
            wanted = {
                ('map', 'alice/odom'), ('map', 'bob/odom'),
                ('alice/odom', 'alice/base_link'), ('bob/odom', 'bob/base_link'),
                ('alice/base_link', 'alice/torso'), ('bob/torso', 'bob/neck'),
                ('bob/base_link', 'bob/base_footprint'),
            }  # fmt: skip
            while not wanted <= seen:  # bounded by the test's time limit
                moving.expect(len(moving.items) + 1)
                transforms = [each for message in fixed.items + moving.items for each in message.transforms]
                seen |= {(each.header.frame_id, each.child_frame_id) for each in transforms}
            assert all(re.match(r'(map|alice/\w+|bob/\w+)$', frame) for pair in seen for frame in pair)
        ros = [('--ros-args', '-r', f'__ns:=/{name}') for name in names]
        with humanoid('mission', *ros[0], env=world) as one, humanoid('mission', *ros[1], env=world) as other:
            assert WHOLE in one.succeed(timeout=120.0)
            assert WHOLE in other.succeed(timeout=120.0)
        with humanoid('status', '--name', 'bob', env=world) as status:
            assert re.search(r'base at \(-?0\.0\d, -?0\.0\d\) m', status.succeed(timeout=60.0))
