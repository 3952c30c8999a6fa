"""The interface for real motors: a driver reads joint states and writes targets; this module does the rest.

`DrivenJoints` is the JointSource that JointStateService owns. It calls its driver from a thread of its own,
50 times a second, so the driver's bus may block for up to 20 ms. Commands become targets along their paths,
at most as fast as the joints' limits allow. A watchdog drops all commands and lets every joint hold where it
is, if nobody has called `update` for 0.5 s, or if the motors have not answered for as long. An answer with a
reading that is not a number counts as no answer.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Collection, Mapping
from typing import Protocol

from humanoid.joints.commands import Plan
from humanoid.joints.kinematic import Path
from humanoid.joints.source import JointSample, NotANumber, check_finite
from humanoid.model import JOINT_BY_NAME, JointSpec

PERIOD = 0.02  # s between two targets of a joint: 50 Hz
HOLD_AFTER = 0.5  # s without a call of `update` or an answer of the motors, after which the joints hold
SILENT_AFTER = 0.2  # s without an answer of the motors, after which `update` raises DriverError
FIRST_ANSWER_WITHIN = 5.0  # s to wait for the motors' first answer


class DriverError(Exception):
    """The motors cannot be reached; the text says what happened, and where."""


class MotorDriver(Protocol):
    """The motors of one robot. All calls but `close` come from one thread, in turns: `write`, then `read`.

    Each call may block for 20 ms at most. `write` and `read` raise DriverError if the motors do not answer.
    They are called again in the next period, so a driver that lost its line can reopen it then.
    """

    def write(self, targets: Mapping[str, float], /) -> None:
        """Send target positions (rad or m) to the motors; an empty mapping only asks for their states."""

    def read(self) -> Mapping[str, JointSample]:
        """Return the present state of each joint that the motors report."""

    def close(self) -> None:
        """Close the line. May be called twice."""


class DrivenJoints:
    """A JointSource that moves real joints through a MotorDriver. `close` ends its thread."""

    def __init__(
        self,
        driver: MotorDriver,
        joints: Mapping[str, JointSpec] = JOINT_BY_NAME,
        now: float = 0.0,
        hold_after: float = HOLD_AFTER,
    ) -> None:
        """`now`: the node's clock, in s. Blocks until the motors have answered. Raises DriverError.

        `hold_after`: s after which the watchdog makes the joints hold.
        """
        self._hold_after = hold_after
        self._driver, self._joints = driver, joints
        self._lock = threading.Lock()  # held for a few assignments only, so that no thread waits long
        self._clock = now, time.monotonic()  # at the last update: the node's time and the steady time
        self._paths: dict[str, Path] = {}
        self._targets: dict[str, float] = {}
        self._held = False
        self._readings: Mapping[str, JointSample] = self._first()
        self._read_at = time.monotonic()
        self._samples = dict(self._readings)
        self._trouble = ''
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name='motors', daemon=True)
        self._thread.start()

    def _first(self) -> Mapping[str, JointSample]:
        deadline = time.monotonic() + FIRST_ANSWER_WITHIN
        while True:
            try:
                self._driver.write({})
                readings = self._driver.read()
                _check(readings)
            except DriverError:
                if time.monotonic() > deadline:
                    self._driver.close()
                    raise
                time.sleep(PERIOD)
                continue
            missing = [name for name in self._joints if name not in readings]
            if missing:
                self._driver.close()
                raise DriverError(f'the motors do not tell of {", ".join(missing)}')
            return readings

    def close(self) -> None:
        """End the thread and close the driver; the motors then hold by their own watchdog. Idempotent."""
        self._over.set()
        self._thread.join()
        self._driver.close()

    @property
    def joints(self) -> Mapping[str, JointSpec]:
        return self._joints

    @property
    def holds(self) -> bool:
        """True if the watchdog has made the joints hold."""
        return self._held

    def update(self, now: float) -> None:
        """Note the node's time, and take the latest readings. Raises DriverError if the motors are silent."""
        with self._lock:
            self._clock = now, time.monotonic()
            self._samples = dict(self._readings)
            silent = time.monotonic() - self._read_at
            trouble = self._trouble
        if silent > SILENT_AFTER:
            raise DriverError(f'no answer of the motors for {silent:.1f} s: {trouble or "they are silent"}')

    def read(self, name: str) -> JointSample:
        return self._samples[name]

    def follow(self, plan: Plan, start: float) -> None:
        with self._lock:
            for name, waypoints in plan.items():
                here = self._readings[name]
                if waypoints:
                    self._paths[name] = Path.begin(start, here, waypoints)
                else:
                    self._paths.pop(name, None)
                    self._targets[name] = here.position

    def _run(self) -> None:
        due = time.monotonic()
        while not self._over.wait(max(due - time.monotonic(), 0.0)):
            due = max(due + PERIOD, time.monotonic())
            try:
                self._driver.write(self._next_targets())
                readings = self._driver.read()
                _check(readings, self._joints)
            except Exception as error:  # any exception of the driver counts as no answer of the motors
                with self._lock:
                    self._trouble = str(error) or type(error).__name__
                continue
            with self._lock:
                self._readings, self._read_at, self._trouble = readings, time.monotonic(), ''

    def _next_targets(self) -> Mapping[str, float]:
        with self._lock:
            moment = time.monotonic()
            told, at = self._clock
            if max(moment - at, moment - self._read_at) > self._hold_after:
                if not self._held:
                    self._held = True
                    self._paths.clear()
                    self._targets = {name: self._readings[name].position for name in self._joints}
                return dict(self._targets)
            self._held = False
            for name, path in self._paths.items():
                joint, here = self._joints[name], self._readings[name].position
                before = self._targets.get(name, here)
                reach = joint.max_velocity * PERIOD
                wanted = path.position_at(told + moment - at)
                self._targets[name] = min(
                    max(wanted, before - reach, joint.lower), before + reach, joint.upper
                )
            return dict(self._targets)


def _check(readings: Mapping[str, JointSample], joints: Collection[str] = ()) -> None:
    """Raise DriverError if one of the joints is missing, or a reading is not a number."""
    for name in joints:
        if name not in readings:
            raise DriverError(f'the motors do not tell of {name}')
    try:
        check_finite(readings)
    except NotANumber as error:
        raise DriverError(str(error)) from None
