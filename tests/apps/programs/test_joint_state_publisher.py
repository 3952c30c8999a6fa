"""joint_state_publisher and its sliders: which joints are published, by which rules, and where they stand."""

from __future__ import annotations

import json
import os
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import pytest
from apps.programs.conftest import Run
from helpers.browser import chromium
from helpers.markdown import ROOT
from helpers.page import until
from helpers.processes import Program

from goalwire.apps.programs.joint_state_publisher.joints import JointSettings, JointTable, UnusableJointsError
from goalwire.transforms.urdf import Mimic, read_kinematics

PACKAGE = 'joint_state_publisher'
ARM = """
<robot name="arm"><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
<joint name="wheel" type="continuous"><parent link="a"/><child link="b"/></joint>
<joint name="still" type="fixed"><parent link="a"/><child link="e"/></joint>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/>
<limit lower="0.2" upper="0.6"/></joint>
<joint name="finger" type="revolute"><parent link="c"/><child link="d"/><limit lower="-1" upper="1"/>
<safety_controller soft_lower_limit="-0.5"/><mimic joint="wheel" multiplier="2" offset="1"/></joint></robot>
"""


def table(**settings: object) -> JointTable:
    given: dict[str, object] = {'zeros': {}, 'dependents': {}} | settings
    return JointTable(read_kinematics(ARM), JointSettings(**given))  # type: ignore[arg-type]


def test_movable_joints_are_published_in_the_order_of_the_text() -> None:
    names, positions, velocities, efforts = table().fill()
    assert names == ['wheel', 'slide', 'finger']
    assert positions == pytest.approx([0.0, 0.4, 1.0])  # 0, the middle of limits without 0, 2 times 0 plus 1
    assert (velocities, efforts) == ([], [])


def test_zeros_are_where_joints_begin_and_defaults_may_be_left_out() -> None:
    assert table(zeros={'wheel': 0.5}).fill()[1] == pytest.approx([0.5, 0.4, 2.0])
    names, positions, velocities, efforts = table(
        positions=False, velocities=True, efforts=True, use_mimic_tags=False
    ).fill()
    assert (len(names), positions, velocities, efforts) == (3, [], [0.0] * 3, [0.0] * 3)


def test_the_smaller_of_the_joints_limits_count_unless_told_otherwise() -> None:
    assert table(use_mimic_tags=False).free['finger'].lower == -0.5
    assert table(use_mimic_tags=False, use_smallest_joint_limits=False).free['finger'].lower == -1.0


def test_a_joint_may_depend_on_another_one_that_the_urdf_does_not_name() -> None:
    tested = table(dependents={'wheel': Mimic('slide', -1.0)})
    assert tested.fill()[1] == pytest.approx([-0.4, 0.4, 0.2])
    tested.take(['slide', 'wheel', 'nobody'], [0.5, 9.0, 1.0], [2.0], [])
    assert tested.fill()[1] == pytest.approx([-0.5, 0.5, 0.0])
    assert tested.fill()[2] == pytest.approx([-2.0, 2.0, -4.0])


@pytest.mark.parametrize(
    ('dependents', 'problem'),
    [
        ({'wheel': Mimic('finger')}, 'in a circle: wheel -> finger -> wheel'),
        ({'slide': Mimic('still')}, "'slide' follows 'still', which is not a movable joint"),
    ],
)
def test_joints_that_follow_no_free_one_are_refused(dependents: dict[str, Mimic], problem: str) -> None:
    with pytest.raises(UnusableJointsError, match=problem):
        table(dependents=dependents)


def test_joints_move_to_and_fro_and_continuous_ones_round() -> None:
    tested = table()
    seen = []
    for _ in range(40):
        tested.move(0.17)
        seen.append((tested.free['wheel'].position, tested.free['slide'].position))
    slides = [slide for _, slide in seen if slide is not None]
    assert min(slides) == 0.2
    assert max(slides) == 0.6
    assert tested.free['wheel'].lower in [wheel for wheel, _ in seen]


def test_the_description_of_the_topic_is_used_and_other_publishers_are_taken_over(
    run: Run, isolated: dict[str, str], tmp_path: Path
) -> None:
    (tmp_path / 'arm.urdf').write_text(ARM)
    publisher = run(PACKAGE, PACKAGE, '--ros-args', '-p', 'source_list:=[arm_states]', '-p', 'rate:=50')
    publisher.expect('Waiting for robot_description to be published')
    run('robot_state_publisher', 'robot_state_publisher', 'arm.urdf').expect('Robot initialized')
    echo = run('tf2_ros', 'tf2_echo', 'b', 'c', '20')
    echo.expect(r'- Translation: \[0.400, 0.000, 0.000\]')
    states = '{name: [slide], position: [0.25]}'
    words = ('topic', 'pub', '-r', '20', '/arm_states', 'sensor_msgs/msg/JointState', states)
    with Program(Path('-m'), 'goalwire', *words, env=isolated):
        echo.expect(r'- Translation: \[0.250, 0.000, 0.000\]')


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        (['/nowhere.urdf'], '/nowhere.urdf cannot be used'),
        (['--ros-args', '-p', 'rate:=0'], 'the parameter rate is 0: it must be above 0'),
        (['--ros-args', '-p', 'rate:=fast'], "the parameter rate is 'fast': it must be a whole number"),
        (
            ['--ros-args', '-p', 'zeros.wheel:=high'],
            "zeros.wheel is 'high': it must be a number",
        ),
        (
            ['--ros-args', '-p', 'dependent_joints.wheel.factor:=2.0'],
            'name the joint that wheel follows',
        ),
        (['--ros-args', '-p', 'dependent_joints.wheel.speed:=2.0'], 'does not end with .parent, .factor'),
    ],
)
def test_it_says_why_it_cannot_begin(run: Run, arguments: list[str], complaint: str) -> None:
    program = run(PACKAGE, PACKAGE, *arguments)
    assert program.wait() == 1
    assert 'Traceback' not in program.output
    assert complaint in program.output


def sliders(run: Run, tmp_path: Path) -> str:
    (tmp_path / 'arm.urdf').write_text(ARM)
    program = run('joint_state_publisher_gui', 'joint_state_publisher_gui', 'arm.urdf', '--no-open')
    return program.expect(r'the sliders are at (http://127\.0\.0\.1:\d+/)')[1]


def shown(url: str) -> list[list[Any]]:
    """The joints that a browser is sent: name, limits, position."""
    with urllib.request.urlopen(f'{url}events') as events:
        for line in events:
            joints: list[list[Any]] = json.loads(line.strip().removeprefix(b'data: ') or b'{}').get(
                'joints', []
            )
            if joints:
                return joints
    raise AssertionError('the program ended')


def test_only_the_page_itself_may_move_a_slider(run: Run, tmp_path: Path) -> None:
    url = sliders(run, tmp_path)
    assert [joint[0] for joint in shown(url)] == ['wheel', 'slide']

    def post(body: bytes, **headers: str) -> int:
        named = {name.replace('_', '-'): value for name, value in headers.items()}
        request = urllib.request.Request(f'{url}command', body, named)
        try:
            with urllib.request.urlopen(request) as answer:
                return int(answer.status)
        except urllib.error.HTTPError as error:
            return error.code

    good = json.dumps({'set': {'slide': 0.3, 'finger': 'x', 'nobody': 1}}).encode()
    assert post(good) == 404
    assert post(good, X_Window_Command='1', Host='evil.example:80') == 403
    assert post(b'[]', X_Window_Command='1') == 400
    assert post(b'{', X_Window_Command='1') == 400
    assert post(b'1' * 70_000, X_Window_Command='1') == 400
    assert post(good, X_Window_Command='1') == 204
    assert shown(url)[1][3] == 0.3


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_a_slider_moves_its_link(run: Run, tmp_path: Path) -> None:
    url = sliders(run, tmp_path)
    run('robot_state_publisher', 'robot_state_publisher', 'arm.urdf').expect('Robot initialized')
    echo = run('tf2_ros', 'tf2_echo', 'b', 'c', '20')
    echo.expect(r'- Translation: \[0.400, 0.000, 0.000\]')
    with chromium() as browser:
        page = browser.new_page(viewport={'width': 760, 'height': 400})
        page.goto(url)
        page.locator('[data-joint=slide]').fill('0.5')
        echo.expect(r'- Translation: \[0.500, 0.000, 0.000\]')
        page.click('#randomize')
        until(page, "() => document.querySelector('[data-joint=wheel]').value != 0")
        page.click('#centre')
        echo.expect(r'- Translation: \[0.400, 0.000, 0.000\]')
        folder = Path(os.environ.get('GOALWIRE_SCREENSHOTS') or ROOT / 'build' / 'screenshots')
        folder.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=folder / 'joint_state_publisher_gui.png')
