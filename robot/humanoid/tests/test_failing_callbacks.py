"""A callback of a robot's server that raises ends its own goal or request; the server goes on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import pytest
import rclpy
from helpers.processes import Program
from helpers.robot import humanoid, server_of_robots

from humanoid.mission.calls import GoalRun
from humanoid.mission.retry import Backoff, NoAnswer, retry
from humanoid.mission.robot import Robot
from humanoid.running import log_failure

pytestmark = pytest.mark.slow

WITHIN = 15.0
SABOTAGED = """
import importlib, sys
from humanoid.cli import main

where, name, skipped = sys.argv.pop(1), sys.argv.pop(1), int(sys.argv.pop(1))
module, _, of_class = where.partition(':')
owner = importlib.import_module(module)
owner = getattr(owner, of_class) if of_class else owner
sound, calls = getattr(owner, name), 0

def fails_once(*args, **kwargs):
    global calls
    calls += 1
    if calls == skipped + 1:
        raise ArithmeticError('sabotage ' + 'x' * 100_000)
    return sound(*args, **kwargs)

setattr(owner, name, fails_once)
raise SystemExit(main())
"""


@contextmanager
def sabotaged(
    program: str, where: str, name: str, world: Mapping[str, str], skipped: int = 0, first: str = 'ready'
) -> Iterator[Program]:
    """A server whose function `name` fails at one call, after `skipped` calls that do not.

    It has written that it is ready, and a line with `first`.
    """
    with Program(
        SABOTAGED, where, name, str(skipped), program, env=world, server=server_of_robots(None)
    ) as server:
        server.expect_each('ready', first)
        yield server
        assert 'ArithmeticError: sabotage' in server.output


def test_the_log_names_the_error_at_the_end_of_a_long_traceback(capfd: pytest.CaptureFixture[str]) -> None:
    def call(left: int) -> None:
        fail(left - 1)

    def fail(left: int) -> None:
        if not left:
            raise ArithmeticError('sabotage ' + 'x' * 100_000)
        call(left)

    rclpy.init(args=[])
    try:
        node = rclpy.create_node('server')
        try:
            fail(100)
        except ArithmeticError as error:
            log_failure(node, error)
        node.destroy_node()
    finally:
        rclpy.shutdown()
    told = capfd.readouterr().err
    assert 'ArithmeticError: sabotage' in told
    assert len(told) < 6000


def drive(robot: Robot) -> GoalRun:
    return robot.drive(0.1, 0.0, allowed=10.0, timeout=WITHIN)


def reach(robot: Robot) -> GoalRun:
    return robot.reach({'left_arm_elbow': 0.2}, duration=0.5, timeout=WITHIN)


GOALS = {'navigation_action_server': drive, 'arm_action_server': reach}


@pytest.fixture
def joints(world: dict[str, str]) -> Iterator[None]:
    with humanoid('joint_state_service', env=world):
        yield


@pytest.mark.parametrize(
    ('program', 'where', 'name', 'told'),
    [
        ('navigation_action_server', 'humanoid.navigation.server', 'target_of', True),
        ('navigation_action_server', 'humanoid.navigation.server:NavigationActionServer', '_follow_up', True),
        ('navigation_action_server', 'humanoid.goal_endings', 'settle', False),
        ('arm_action_server', 'humanoid.arm.server', 'ArmMotion', True),
        ('arm_action_server', 'humanoid.arm.server:ArmActionServer', '_command', True),
        ('arm_action_server', 'humanoid.arm.motion:ArmMotion', 'fraction_done', True),
        ('arm_action_server', 'humanoid.goal_endings', 'settle', False),
    ],
)
def test_a_goal_whose_server_fails_is_aborted_and_the_next_one_succeeds(
    world: dict[str, str], joints: None, robot: Robot, program: str, where: str, name: str, told: bool
) -> None:
    with sabotaged(program, where, name, world) as server:
        with GOALS[program](robot) as run:
            run.finish()
        assert run.status == 'ABORTED'
        if told:
            assert run.result.message.startswith('the server failed: ArithmeticError: sabotage')
            assert len(run.result.message) < 500
            assert len(server.output) < 10_000
        with GOALS[program](robot) as run:
            run.finish()
        assert run.status == 'SUCCEEDED', run.result.message


@pytest.mark.parametrize(
    ('program', 'where'),
    [
        ('navigation_action_server', 'humanoid.navigation.server'),
        ('arm_action_server', 'humanoid.arm.server'),
    ],
)
def test_a_goal_whose_check_fails_is_refused(
    world: dict[str, str], joints: None, robot: Robot, program: str, where: str
) -> None:
    with sabotaged(program, where, 'refusal', world) as server:
        with GOALS[program](robot) as run:
            assert not run.accepted
        with GOALS[program](robot) as run:
            assert run.accepted, server.output
            run.finish()
        assert run.status == 'SUCCEEDED'


@pytest.mark.parametrize(
    ('program', 'where', 'name'),
    [
        ('joint_state_service', 'humanoid.joints.service:JointStateService', '_tick'),
        ('battery_service', 'humanoid.battery.service:BatteryService', '_tick'),
        ('navigation_action_server', 'humanoid.navigation.server:NavigationActionServer', '_tick'),
        ('arm_action_server', 'humanoid.arm.server:ArmActionServer', '_tick'),
        ('arm_action_server', 'humanoid.arm.server:ArmActionServer', '_see'),
        ('battery_service', 'humanoid.battery.service:BatteryService', '_see_joints'),
    ],
)
def test_a_timer_or_subscription_that_fails_once_goes_on(
    world: dict[str, str], joints: None, robot: Robot, program: str, where: str, name: str
) -> None:
    # The arm's server is ready once it knows the emergency stop and the joints. It may have failed before.
    with sabotaged(program, where, name, world, skipped=3, first='sabotage'):
        if program in GOALS:
            with GOALS[program](robot) as run:
                run.finish()
            assert run.status == 'SUCCEEDED'
        elif program == 'battery_service':
            robot.battery(WITHIN)
        else:
            robot.joint('left_knee', WITHIN)


@pytest.mark.parametrize(
    ('program', 'where'),
    [
        ('joint_state_service', 'humanoid.joints.service:JointStateService'),
        ('battery_service', 'humanoid.battery.service:BatteryService'),
    ],
)
def test_a_request_that_fails_its_server_does_not_end_it(
    world: dict[str, str], robot: Robot, program: str, where: str
) -> None:
    def ask(timeout: float) -> object:
        return robot.joint('left_knee', timeout) if 'joint' in program else robot.battery(timeout)

    def told(attempt: int, pause: float, why: NoAnswer) -> None:
        failed.append(str(why))

    failed: list[str] = []
    with sabotaged(program, where, '_answer', world):
        retry(ask, attempt_timeout=2.0, timeout=60.0, backoff=Backoff(), on_retry=told)
    assert failed, 'the first request was answered'
