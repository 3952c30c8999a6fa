"""Estimates the body's pose and motion from an inertial sensor, joint encoders and soles.

The gyroscope's rates are integrated to the orientation; the accelerometer shows on average where down is. A
Kalman filter estimates position and velocity from the acceleration, and from the assumption that a foot under
load stands still on the floor at height 0 (Bloesch et al.: State estimation for legged robots, 2012, in the
linear form that fixes the orientation first).
"""

from __future__ import annotations

import math

import numpy as np

from humanoid.walking.body import Body
from humanoid.walking.seam import Array, Sensed

GRAVITY = 9.80665  # m/s²
LEVELS = 0.1  # 1/s: how fast the accelerometer corrects the orientation
LEARNS = 0.02  # 1/s²: how fast the accelerometer corrects the gyroscope's bias
BEARS = 40.0  # N: with less load a foot is not assumed to stand still
UNTRUSTED = 1e4  # factor on the variances of a foot that may move
PULL_NOISE = 1.0  # m/s²: noise of the accelerometer and of unmodelled motion
CREEP = 0.02  # m/s: noise of the speed of a foot that slides on the floor
REACH_NOISE = 0.004  # m: noise of a foot's position by the leg's kinematics
SPEED_NOISE = 0.1  # m/s: noise of a foot's speed by the leg's kinematics
FLOOR_NOISE = 0.004  # m: noise of the floor's height


class Estimator:
    """Estimates the body's state, and sets a Body to the estimate."""

    def __init__(self, body: Body, period: float, position: Array, yaw: float) -> None:
        """`position` (m) and `yaw` (rad) are the start pose; the body begins upright and at rest."""
        self._body, self._period = body, period
        self.orientation = np.array((math.cos(yaw / 2.0), 0.0, 0.0, math.sin(yaw / 2.0)))  # w, x, y, z
        self.bias = np.zeros(3)  # rad/s: the estimated bias of the gyroscope
        # Columns: x, y and z. Rows: the pelvis' position and velocity, the left and right soles' positions.
        self._state = np.zeros((4, 3))
        self._state[0] = position
        self._level, self._height = np.eye(4) * 1e-2, np.eye(4) * 1e-2  # covariances of x (and y), and of z
        self._model = np.eye(4)
        self._model[0, 1] = period
        self._begun = False

    def update(self, sensed: Sensed) -> None:
        """Take the sensors' readings, and set the body to the new estimate."""
        rate = self._turn(sensed)
        turn = _matrix(self.orientation)
        self._predict(turn @ sensed.acceleration - (0.0, 0.0, GRAVITY), sensed.loads)
        place, speed = self._state[0].copy(), self._state[1].copy()
        self._body.set(place, self.orientation, np.concatenate((speed, rate)), sensed.angles, sensed.speeds)
        if not self._begun:
            self._begun = True
            low = min(self._body.sole(side)[2] for side in (0, 1))
            self._state[0, 2] -= low
            for side in (0, 1):
                self._state[2 + side] = self._body.sole(side) - (0.0, 0.0, low)
        self._correct(sensed.loads, place, speed)
        self._body.shift(self._state[0] - place, self._state[1] - speed)

    def _turn(self, sensed: Sensed) -> Array:
        """Update the orientation; return the pelvis' angular velocity in its own frame."""
        up = _matrix(self.orientation)[2]  # the world's z in the pelvis' frame
        pull = sensed.acceleration
        size = math.sqrt(float(pull @ pull))
        rate = sensed.turn_rate - self.bias
        if abs(size - GRAVITY) < 0.2 * GRAVITY:
            off = _cross(pull / size, up)
            self.bias = np.clip(self.bias - LEARNS * self._period * off, -0.05, 0.05)
            moved = rate + LEVELS * off
        else:
            moved = rate
        self.orientation = _turn_by(self.orientation, moved * self._period)
        return rate

    def _predict(self, pull: Array, loads: Array) -> None:
        dt = self._period
        state = self._state
        state[0] += state[1] * dt + pull * (dt**2 / 2.0)
        state[1] += pull * dt
        noise = np.diag(
            [(PULL_NOISE * dt**2 / 2.0) ** 2 + 1e-10, (PULL_NOISE * dt) ** 2]
            + [(CREEP * dt) ** 2 * (1.0 if load > BEARS else UNTRUSTED) for load in loads]
        )
        model = self._model
        self._level = model @ self._level @ model.T + noise
        self._height = model @ self._height @ model.T + noise

    def _correct(self, loads: Array, place: Array, speed: Array) -> None:
        body = self._body
        rows, seen, noise = np.zeros((6, 4)), np.zeros((6, 3)), np.zeros(6)
        for side in (0, 1):
            doubt = 1.0 if loads[side] > BEARS else UNTRUSTED
            rows[side, 0], rows[side, 2 + side] = -1.0, 1.0
            seen[side] = body.sole(side) - place
            noise[side] = REACH_NOISE**2
            rows[2 + side, 1] = 1.0
            seen[2 + side] = speed - body.sole_speed(side)[:3]
            noise[2 + side] = SPEED_NOISE**2 * doubt
            rows[4 + side, 2 + side] = 1.0
            noise[4 + side] = FLOOR_NOISE**2 * doubt  # used for z only
        level = rows[:4]
        gain = self._level @ level.T @ np.linalg.inv(level @ self._level @ level.T + np.diag(noise[:4]))
        self._state[:, :2] += gain @ (seen[:4, :2] - level @ self._state[:, :2])
        self._level = _symmetric(self._level - gain @ level @ self._level)
        gain = self._height @ rows.T @ np.linalg.inv(rows @ self._height @ rows.T + np.diag(noise))
        self._state[:, 2] += gain @ (seen[:, 2] - rows @ self._state[:, 2])
        self._height = _symmetric(self._height - gain @ rows @ self._height)


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product; numpy's function would take longer than the rest of the estimator."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def _symmetric(matrix: Array) -> Array:
    return (matrix + matrix.T) / 2.0


def _matrix(turn: Array) -> Array:
    w, x, y, z = turn
    return np.array(
        (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        )
    )


def _turn_by(turn: Array, by: Array) -> Array:
    """Return the orientation `turn` after a small rotation vector in its own frame."""
    angle = math.sqrt(float(by @ by))
    half = math.sin(angle / 2.0) / angle if angle > 1e-12 else 0.5
    bw, (bx, by_, bz) = math.cos(angle / 2.0), by * half
    w, x, y, z = turn
    new = np.array(
        (
            w * bw - x * bx - y * by_ - z * bz,
            w * bx + x * bw + y * bz - z * by_,
            w * by_ - x * bz + y * bw + z * bx,
            w * bz + x * by_ - y * bx + z * bw,
        )
    )
    return new / math.sqrt(float(new @ new))
