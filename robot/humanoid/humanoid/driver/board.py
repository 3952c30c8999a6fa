"""motor_board: simulated motors behind a pseudo-terminal, the other end of the example driver's serial line.

The program stands in for the firmware of a real board, so that the driver can be tried without a board.
"""

from __future__ import annotations

import argparse
import math
import os
import pty
import select
import time
import tty
from collections.abc import Callable, Sequence

from humanoid.driver.frames import Decoder, Frame, positions_of, states
from humanoid.model import JOINTS, JointSpec
from humanoid.text import finite

HOLD_AFTER = 0.5  # s without a frame after which the motors hold
PERIOD = 0.02  # s between two steps of the motors


class MotorBoard:
    """Motors that go to their targets as fast as they can, and hold if no frame comes for HOLD_AFTER s."""

    def __init__(self, joints: Sequence[JointSpec] = JOINTS, hold_after: float = HOLD_AFTER) -> None:
        self._hold_after = hold_after
        self.positions = [joint.home for joint in joints]
        self.holds = True
        self._joints = joints
        self._velocities = [0.0] * len(joints)
        self._targets = list(self.positions)
        self._moved = self._heard = time.monotonic()
        self._decoder = Decoder()

    @property
    def damaged(self) -> int:
        """How many frames arrived with a wrong checksum."""
        return self._decoder.damaged

    def receive(self, data: bytes) -> bytes:
        """Take bytes from the line and return the board's answer."""
        return b''.join(self._answer(frame) for frame in self._decoder.feed(data))

    def _answer(self, frame: Frame) -> bytes:
        try:
            wanted = positions_of(frame)
        except ValueError:
            return b''
        self.move()
        self._heard, self.holds = time.monotonic(), False
        for index, position in wanted.items():
            if index < len(self._targets) and math.isfinite(position):
                joint = self._joints[index]
                self._targets[index] = min(max(position, joint.lower), joint.upper)
        told = zip(self.positions, self._velocities, self._joints, strict=True)
        return states(
            frame.number, [(at, speed, joint.friction * speed) for at, speed, joint in told]
        ).encode()

    def move(self) -> None:
        """Move the simulated motors on to the present time."""
        moment = time.monotonic()
        elapsed, self._moved = moment - self._moved, moment
        if moment - self._heard > self._hold_after:
            self.holds = True
            self._targets = list(self.positions)
        if elapsed <= 0.0:
            return
        for index, joint in enumerate(self._joints):
            before, reach = self.positions[index], joint.max_velocity * elapsed
            after = min(max(self._targets[index], before - reach), before + reach)
            self.positions[index], self._velocities[index] = after, (after - before) / elapsed


def serve(board: MotorBoard, line: int, over: int, spoil: Callable[[bytes], bytes] = bytes) -> None:
    """Answer frames on `line` until `over` becomes readable. `spoil` may damage the answers' bytes."""
    while True:
        ready = select.select([line, over], [], [], PERIOD)[0]
        board.move()
        if over in ready:
            return
        if not ready:
            continue
        try:
            data = os.read(line, 65536)
        except OSError:  # no program has opened the other end of the line
            time.sleep(PERIOD)
            continue
        answer = spoil(board.receive(data))
        if answer:
            os.write(line, answer)


def main(args: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog='motor_board', description='Motors on a pseudo terminal, until Ctrl-C.'
    )
    parser.add_argument('--hold-after', type=finite, default=HOLD_AFTER, help='s without a frame (0.5)')
    options = parser.parse_args(args)
    line, other = pty.openpty()
    tty.setraw(other)
    name = os.ttyname(other)
    over, _unused = os.pipe()
    print(
        f'the board is at {name}; humanoid joint_state_service --ros-args -p serial_port:={name}', flush=True
    )
    serve(MotorBoard(hold_after=options.hold_after), line, over)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
