"""An example driver, for POSIX: it speaks humanoid.driver.frames with a motor board on a serial line."""

from __future__ import annotations

import os
import select
import termios
import time
import tty
from collections.abc import Mapping, Sequence

from humanoid.driver.frames import STATES, Decoder, Frame, joints_of, targets
from humanoid.driver.seam import DriverError
from humanoid.joints.source import JointSample
from humanoid.model import JOINT_BY_NAME

ANSWER_WITHIN = 0.02  # s
REOPEN_EVERY = 0.5  # s between attempts to open an unplugged line
SPEED = termios.B115200 if not hasattr(termios, 'B1000000') else termios.B1000000


class SerialMotors:
    """A MotorDriver for a serial line. After the line was unplugged, it is reopened when it is back."""

    def __init__(self, path: str, names: Sequence[str] = tuple(JOINT_BY_NAME)) -> None:
        """`names`: the joints in the order of the board's indices. The first `write` opens the line."""
        self._path, self._names = path, names
        self._index = {name: index for index, name in enumerate(names)}
        self._line: int | None = None
        self._tried = -REOPEN_EVERY
        self._why = f'{path} is unplugged'  # why the line is closed
        self._decoder = Decoder()
        self._number = 0

    @property
    def damaged(self) -> int:
        """How many answers arrived with a wrong checksum."""
        return self._decoder.damaged

    def write(self, targets_: Mapping[str, float]) -> None:
        line = self._open()
        self._number = (self._number + 1) % 256
        frame = targets(self._number, {self._index[name]: angle for name, angle in targets_.items()})
        try:
            left = frame.encode()
            while left:
                if not select.select([], [line], [], ANSWER_WITHIN)[1]:
                    raise DriverError(f'{self._path} takes no more bytes')
                left = left[os.write(line, left) :]
        except OSError as error:
            raise self._fail(error) from error

    def read(self) -> Mapping[str, JointSample]:
        """Return the answer to the last `write`; late answers to earlier ones are skipped."""
        line = self._open()
        deadline = time.monotonic() + ANSWER_WITHIN
        while True:
            left = deadline - time.monotonic()
            try:
                if left <= 0.0 or not select.select([line], [], [], left)[0]:
                    raise DriverError(f'the board at {self._path} does not answer')
                data = os.read(line, 65536)
            except OSError as error:
                raise self._fail(error) from error
            if not data:
                raise self._fail(OSError('it is closed at the other end'))
            for frame in self._decoder.feed(data):
                if (frame.kind, frame.number) == (STATES, self._number):
                    return self._readings(frame)

    def _readings(self, frame: Frame) -> Mapping[str, JointSample]:
        joints = joints_of(frame)
        if len(joints) != len(self._names):
            raise DriverError(
                f'the board at {self._path} tells of {len(joints)} joints, not {len(self._names)}'
            )
        return {name: JointSample(*joint) for name, joint in zip(self._names, joints, strict=True)}

    def _open(self) -> int:
        if self._line is not None:
            return self._line
        if time.monotonic() - self._tried < REOPEN_EVERY:
            raise DriverError(self._why)
        self._tried = time.monotonic()
        try:
            line = os.open(self._path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise self._no_line(f'cannot be opened: {error.strerror}') from error
        try:
            tty.setraw(line)
            settings = termios.tcgetattr(line)
            settings[4] = settings[5] = SPEED
            termios.tcsetattr(line, termios.TCSANOW, settings)
        except termios.error as error:
            os.close(line)
            raise self._no_line(f'is not a serial line: {error}') from error
        self._line, self._decoder = line, Decoder()
        return line

    def _no_line(self, why: str) -> DriverError:
        self._why = f'{self._path} {why}'
        return DriverError(self._why)

    def _fail(self, error: OSError) -> DriverError:
        self.close()
        self._tried = time.monotonic()
        return self._no_line(f'is lost: {error.strerror or error}')

    def close(self) -> None:
        line, self._line = self._line, None
        if line is not None:
            os.close(line)
