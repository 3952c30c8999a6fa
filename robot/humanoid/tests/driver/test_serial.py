"""The example driver on a pseudo terminal whose other end is a motor board."""

from __future__ import annotations

import math
import os
import pty
import random
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest
from helpers.patience import wait_for
from helpers.processes import Program
from helpers.robot import humanoid

from humanoid.driver.board import MotorBoard, serve
from humanoid.driver.frames import Decoder, states
from humanoid.driver.seam import DrivenJoints, DriverError
from humanoid.driver.serial import SerialMotors
from humanoid.joints.commands import Waypoint
from humanoid.mission.robot import Robot
from humanoid.model import JOINT_BY_NAME

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='serial lines of POSIX')

PATIENT = 30.0  # s: a watchdog that must not bite
DEADLINE = 30.0  # s
KNEE = 'left_knee'
KNEES_INDEX = list(JOINT_BY_NAME).index(KNEE)


class Bench:
    """A board at the end of a line; `spoil` changes what it answers."""

    def __init__(self, hold_after: float = PATIENT, spoil: Callable[[bytes], bytes] = bytes) -> None:
        self.board = MotorBoard(hold_after=hold_after)
        self._line, other = pty.openpty()
        tty.setraw(other)
        self.path = os.ttyname(other)
        self._other = other  # kept open, so that a driver may come and go
        self._over, self._end = os.pipe()
        self._thread = threading.Thread(target=serve, args=[self.board, self._line, self._over, spoil])
        self._thread.start()

    def stop(self) -> None:
        """The board loses its power, and the line is gone."""
        if self._thread.is_alive():
            os.write(self._end, b'x')
            self._thread.join()
            for descriptor in (self._line, self._other, self._over, self._end):
                os.close(descriptor)


@pytest.fixture
def benches() -> Iterator[list[Bench]]:
    made: list[Bench] = []
    yield made
    for bench in made:
        bench.stop()


@pytest.fixture
def driven(benches: list[Bench]) -> Iterator[Callable[..., DrivenJoints]]:
    made: list[DrivenJoints] = []

    def drive(bench: Bench, hold_after: float = PATIENT) -> DrivenJoints:
        benches.append(bench)
        joints = DrivenJoints(SerialMotors(bench.path), now=time.monotonic(), hold_after=hold_after)
        made.append(joints)
        return joints

    yield drive
    for joints in made:
        joints.close()


def go(joints: DrivenJoints, angle: float, seconds: float) -> None:
    joints.follow({KNEE: [Waypoint(seconds, angle)]}, time.monotonic())


def update_until(joints: DrivenJoints, condition: Callable[[], bool]) -> None:
    """As a node does, 50 times a second."""
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline
        with suppress(DriverError):  # a machine that is busy elsewhere
            joints.update(time.monotonic())
        time.sleep(0.02)  # its period


def near(joints: DrivenJoints, angle: float) -> bool:
    return abs(joints.read(KNEE).position - angle) < 1e-3


def test_joints_follow_over_the_line(driven: Callable[..., DrivenJoints]) -> None:
    joints = driven(Bench())
    assert joints.read('left_arm_shoulder').position == 0.5
    go(joints, 0.8, 0.5)
    update_until(joints, partial(near, joints, 0.8))
    assert joints.read('right_knee').position == 0.0
    joints.follow({KNEE: []}, time.monotonic())


def test_lost_and_changed_bytes_cost_readings_not_the_motion(driven: Callable[..., DrivenJoints]) -> None:
    rng = random.Random(3)

    def spoil(answer: bytes) -> bytes:
        data, chance = bytearray(answer), rng.random()
        if chance < 0.15:
            del data[rng.randrange(len(data))]
        elif chance < 0.3:
            data[rng.randrange(len(data))] ^= 0xFF
        elif chance < 0.4:
            data += b'\xa5\x5a\x01'
        return bytes(data)

    joints = driven(Bench(spoil=spoil))
    for angle in (0.6, 0.1, 0.6):
        go(joints, angle, 0.3)
        update_until(joints, partial(near, joints, angle))
    motors = joints._driver
    assert isinstance(motors, SerialMotors)
    wait_for(lambda: motors.damaged > 0)


def test_a_source_that_nobody_updates_holds(driven: Callable[..., DrivenJoints]) -> None:
    bench = Bench()
    joints = driven(bench, hold_after=0.5)
    joints.update(time.monotonic())
    go(joints, 2.0, 4.0)
    wait_for(lambda: joints.holds)
    wait_for(lambda: bench.board._velocities[KNEES_INDEX] == 0.0)
    joints.update(time.monotonic())
    stood = joints.read(KNEE).position
    assert stood < 1.9
    wait_for(lambda: not joints.holds)
    update_until(joints, lambda: joints.read(KNEE).velocity == 0.0)
    assert joints.read(KNEE).position == pytest.approx(stood, abs=0.1), 'what was dropped is not resumed'


def test_readings_that_are_not_numbers_reach_nobody(driven: Callable[..., DrivenJoints]) -> None:
    broken = threading.Event()

    def spoil(answer: bytes) -> bytes:
        whole = Decoder().feed(answer) if broken.is_set() else ()
        wrong = [(math.nan, 0.0, math.inf)] * len(JOINT_BY_NAME)
        return b''.join(states(frame.number, wrong).encode() for frame in whole) or answer

    joints = driven(Bench(spoil=spoil), hold_after=0.5)
    sent: list[Mapping[str, float]] = []
    motors = joints._driver
    write = motors.write

    def note(targets: Mapping[str, float]) -> None:
        sent.append(targets)
        write(targets)

    motors.write = note  # type: ignore[method-assign]
    go(joints, 2.0, 60.0)
    broken.set()
    with pytest.raises(DriverError, match='left_arm_shoulder is not a number'):
        update_until_it_fails(joints)
    wait_for(lambda: joints.holds)
    told = len(sent)
    wait_for(lambda: len(sent) > told + 5)
    assert all(math.isfinite(target) for targets in sent for target in targets.values())
    assert math.isfinite(joints.read(KNEE).position)
    broken.clear()
    go(joints, 0.3, 0.5)
    update_until(joints, lambda: not joints.holds)


def update_until_it_fails(joints: DrivenJoints) -> None:
    while True:
        joints.update(time.monotonic())
        time.sleep(0.02)  # its period


def test_a_board_that_hears_nothing_holds(benches: list[Bench], monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(hold_after=0.5)
    benches.append(bench)
    motors = SerialMotors(bench.path)
    motors.write({KNEE: 2.0})
    wait_for(lambda: bench.board.positions[KNEES_INDEX] > 0.0)
    wait_for(lambda: bench.board.holds)
    stood, looks, move = list(bench.board.positions), list[None](), bench.board.move
    monkeypatch.setattr(bench.board, 'move', lambda: looks.append(move()))
    wait_for(lambda: len(looks) >= 5)
    assert bench.board.positions == stood
    motors.close()


def test_an_unplugged_line_is_told_and_taken_again(
    driven: Callable[..., DrivenJoints], benches: list[Bench], tmp_path: Path
) -> None:
    link = tmp_path / 'line'
    bench = Bench()
    benches.append(bench)
    link.symlink_to(bench.path)
    joints = DrivenJoints(SerialMotors(str(link)), now=time.monotonic())
    try:
        go(joints, 2.0, 60.0)
        bench.stop()
        link.unlink()
        told: list[str] = []

        def lost() -> bool:
            try:
                joints.update(time.monotonic())
            except DriverError as error:
                told.append(str(error))
            return bool(told) and 'cannot be opened' in told[-1]

        wait_for(lost)
        assert told[-1].startswith('no answer of the motors for ')
        again = Bench()
        benches.append(again)
        link.symlink_to(again.path)

        def back() -> bool:
            try:
                joints.update(time.monotonic())
            except DriverError:
                return False
            return True

        wait_for(back)
        assert joints.read(KNEE).position == pytest.approx(0.0, abs=0.1)
    finally:
        joints.close()


def test_a_line_that_is_none_is_said_in_a_line(world: dict[str, str]) -> None:
    port = ['--ros-args', '-p', 'serial_port:=/dev/null']
    with humanoid('joint_state_service', *port, env=world) as program:
        assert program.wait() == 1
    [line] = program.output.splitlines()
    assert line.startswith('joint_state_service: /dev/null is not a serial line')


@pytest.mark.slow
def test_an_arm_moves_real_motors_and_a_dead_board_aborts_its_goal(
    world: dict[str, str], robot: Robot
) -> None:
    with humanoid('motor_board', '--hold-after', '30', env=world) as board:
        port = board.expect(r'serial_port:=(\S+)')[1]
        parameters = ['--ros-args', '-p', f'serial_port:={port}', '-p', 'hold_after:=30.0']
        with (
            humanoid('joint_state_service', *parameters, env=world),
            humanoid('arm_action_server', env=world) as arm,
        ):
            arm.expect('Arm Action Server ready')
            with robot.reach({KNEE: 1.0}, duration=1.0, timeout=30.0) as run:
                run.finish()
            assert run.status == 'SUCCEEDED', run.result.message
            assert robot.joint(KNEE).position == pytest.approx(1.0, abs=0.01)
            with robot.reach({KNEE: 0.0}, duration=30.0, timeout=60.0) as run:
                next(run.feedback())
                assert isinstance(board, Program)
                board.kill()
                run.finish()
            assert run.status == 'ABORTED'
