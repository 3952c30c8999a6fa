"""`humanoid demo` and `humanoid up` as a user runs them, and what happens when something is killed."""

from __future__ import annotations

import os
import re
import signal
from contextlib import ExitStack

import pytest
from goalwire.testing import VirtualClock
from helpers.patience import PATIENCE
from helpers.processes import Program
from helpers.robot import humanoid, robot_client, wait_until_gone

from humanoid.mission.program import carry_out
from humanoid.mission.steps import steps
from humanoid.mission.summary import Summary

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

SERVERS = ('joint_state_service', 'navigation_action_server', 'battery_service', 'arm_action_server')
GONE_WITHIN = 60.0
DEMO = 120.0  # s for a demo, or a step of one: eight programs begin at once, on machines that do other things


def pid_of(name: str, program: Program) -> int:
    """The pid that the program has told of one of its children."""
    found = re.search(rf'started {name} \(pid (\d+)\)', program.output)
    assert found, f'{name} was not started:\n{program.output}'
    return int(found[1])


def assert_all_gone(program: Program) -> None:
    pids = [int(pid) for pid in re.findall(r'started \w+ \(pid (\d+)\)', program.output)]
    assert pids
    left = [pid for pid in pids if not wait_until_gone(pid, GONE_WITHIN)]
    assert left == []


def test_the_demo_ends_well(world: dict[str, str]) -> None:
    with humanoid('demo', env=world | {'COLUMNS': '160'}) as demo:
        output = demo.succeed(DEMO)
        assert_all_gone(demo)
    assert '10 of 10 steps ended as they should' in output
    assert re.search(
        r'^ok +battery, down at first +answers on a retry +\d+\.\d% on attempt [2-9]', output, re.MULTILINE
    )


@pytest.mark.parametrize('name', ['arm_action_server', 'mission'])
def test_killing_a_program_in_mid_demo_fails_it_by_name(world: dict[str, str], name: str) -> None:
    """One server stands for the four here; below, each of them is killed."""
    with humanoid('demo', env=world) as demo:
        demo.expect(r'^\[3/10\] raise the left arm', DEMO)
        os.kill(pid_of(name, demo), signal.SIGKILL)
        assert demo.wait(DEMO) == 1
        output = demo.output
        assert_all_gone(demo)
    assert re.search(rf'demo failed: {name} \(pid \d+\) was killed by SIGKILL', output)
    assert re.search(r'^cut +\w', output, re.MULTILINE)
    assert 'Traceback' not in output


@pytest.mark.parametrize('number', [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)])
def test_stopping_the_demo_stops_everything_without_a_traceback(
    world: dict[str, str], number: signal.Signals
) -> None:
    """Both signals have one handler, of the supervisor: test_supervisor.py sends it each of them."""
    with humanoid('demo', env=world) as demo:
        demo.expect(r'^\[5/10\] drive to', DEMO)
        demo.send_signal(number)
        assert demo.wait(DEMO) == 1
        output = demo.output
        assert_all_gone(demo)
    assert 'demo failed: stopped on request' in output
    assert 'Traceback' not in output


@pytest.mark.parametrize('command', ['up', pytest.param('demo', marks=pytest.mark.long)])
def test_no_program_outlives_a_killed_supervisor(world: dict[str, str], command: str) -> None:
    """Both commands start their programs by the same supervisor, which gives each program a lifeline."""
    with humanoid(command, env=world) as program:
        if command == 'up':
            for _ in SERVERS:
                program.expect(r'Service ready|Server ready', DEMO)
        else:
            program.expect(r'^\[3/10\]', DEMO)
        program.kill()
        assert_all_gone(program)


def test_up_relays_the_servers_and_stops_them_all_on_ctrl_c(world: dict[str, str]) -> None:
    with humanoid('up', env=world) as up:
        for _ in SERVERS:
            up.expect(r'^\[\w+\] .*(Service|Server) ready', DEMO)
        up.send_signal(signal.SIGINT)
        assert up.wait() == 0
        assert_all_gone(up)
        assert 'Traceback' not in up.output


@pytest.mark.parametrize(
    'victims',
    [['joint_state_service'], ['arm_action_server', 'battery_service', 'navigation_action_server']],
    ids=['the joints', 'all but the joints'],
)
def test_up_keeps_the_others_working_when_one_is_killed(world: dict[str, str], victims: list[str]) -> None:
    """One after the other; each time the others run, and a server that is left answers a newcomer."""
    with humanoid('up', env=world) as up:
        for _ in SERVERS:
            up.expect(r'Service ready|Server ready', DEMO)
        others = set(SERVERS)
        for name in victims:
            os.kill(pid_of(name, up), signal.SIGKILL)
            up.expect(rf'{name} \(pid \d+\) was killed by SIGKILL; the others go on')
            with robot_client() as newcomer:
                if name == 'joint_state_service':
                    newcomer.battery(PATIENCE)
                else:
                    newcomer.joint('left_knee', PATIENCE)
            others.remove(name)
            assert not any(wait_until_gone(pid_of(other, up), 0.0) for other in others)
        up.send_signal(signal.SIGINT)
        assert up.wait() == 1
        assert_all_gone(up)


def test_missions_beside_up_end_well_until_the_robot_is_stopped(world: dict[str, str]) -> None:
    with humanoid('up', env=world) as up:
        for _ in SERVERS:
            up.expect(r'Service ready|Server ready', DEMO)
        with humanoid('mission', '--whole-body', env=world) as mission:
            assert '13 of 13 steps ended as they should' in mission.succeed(DEMO)
            mission.expect(r'\[WARN\].*move_to_position: the goal was aborted: Pre-empted by a newer goal')
            mission.expect(r'\[WARN\].*move_to_position: the goal was aborted: Timed out after 0.5 s')
        with robot_client() as robot:
            assert robot.emergency_stop(stopped=True, timeout=PATIENCE).success
        with humanoid('mission', '--whole-body', env=world | {'COLUMNS': '160'}) as mission:
            assert mission.wait(DEMO) == 1
        for step in ('wave', 'open and close the left hand', 'emergency stop'):
            assert re.search(rf'^FAILED +{step} ', mission.output, re.MULTILINE)
        assert '4 of 13 steps ended as they should' in mission.output


def test_a_stopped_mission_cancels_its_goal_before_it_leaves(world: dict[str, str]) -> None:
    with ExitStack() as running:
        up = running.enter_context(humanoid('up', env=world))
        for _ in SERVERS:
            up.expect(r'Service ready|Server ready', DEMO)
        mission = running.enter_context(humanoid('mission', env=world))
        mission.expect(r'^\[5/10\] drive to', DEMO)
        mission.expect(r'\d% .* m to go')
        mission.send_signal(signal.SIGINT)
        assert mission.wait() == 130
        assert 'Traceback' not in mission.output
        up.expect(r'\[navigation_action_server\].*Goal canceled')


@pytest.mark.usefixtures('gw_graph')
def test_a_mission_without_any_server_fails_in_bounded_time(gw_clock: VirtualClock) -> None:
    mission = steps()
    summary = Summary(len(mission))
    with robot_client() as robot:
        carry_out(robot, mission, summary.note)
    assert gw_clock.elapsed < 60.0
    assert summary.complete
    assert not summary.all_well
    assert re.search(r'^FAILED +battery .*get_battery_status', summary.table(), re.MULTILINE)


@pytest.mark.parametrize('name', SERVERS)
def test_a_server_ends_on_ctrl_c_with_success_and_no_traceback(world: dict[str, str], name: str) -> None:
    with humanoid(name, env=world) as server:
        server.expect('ready|waiting')
        server.send_signal(signal.SIGINT)
        assert server.wait() == 0
        assert 'Traceback' not in server.output


def test_an_unknown_command_is_refused_with_the_known_ones(world: dict[str, str]) -> None:
    with humanoid('fly', env=world) as program:
        assert program.wait() == 2
        assert 'joint_state_service' in program.output
