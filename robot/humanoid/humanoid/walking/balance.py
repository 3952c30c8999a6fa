"""Turns the feet's targets into accelerations of soles, pelvis and centre of mass, and these into torques."""

from __future__ import annotations

import math

import numpy as np

from humanoid.navigation.base import Pose2D, turn_between
from humanoid.walking.body import SIDES, Body
from humanoid.walking.footsteps import in_frame, move_pose
from humanoid.walking.forces import Aims, Contact, ForceControl
from humanoid.walking.gait import LENGTH, WIDTH, Gait, Seen
from humanoid.walking.seam import Array, Wish
from humanoid.walking.swing import Swing

GRAVITY = 9.80665  # m/s²
# Gains (1/s²) and dampings (1/s) that turn errors of position and speed into accelerations.
HEIGHT_GAIN, HEIGHT_DAMPING = 80.0, 18.0
TURN_GAIN, TURN_DAMPING = 120.0, 22.0
FOOT_GAIN, FOOT_DAMPING = 400.0, 40.0
WAIST_GAIN, WAIST_DAMPING = 60.0, 15.0
STANCE_DAMPING = 10.0
TURNS = 1.5  # rad/s: how fast the pelvis' target heading may change
LEANS = 0.5  # s: time constant of the average of the centre of mass beside the pelvis
LEAST, MOST = 1.0, 3000.0  # N: limits of the load on a sole in contact


class Balance:
    """Computes the torques that keep a body upright and walking, from the body's estimated state."""

    def __init__(self, body: Body, period: float, height: float) -> None:
        self.period, self.height = period, height
        self.waist = 0.0  # rad: the target angle of the trunk
        self._body, self._forces = body, ForceControl(body)
        self.gait = Gait(self._feet)
        self._yaw = self.gait.heading
        self._lean = self._off_the_pelvis()

    @property
    def _feet(self) -> tuple[Pose2D, Pose2D]:
        return _flat(self._body, 0), _flat(self._body, 1)

    def _off_the_pelvis(self) -> Array:
        """Return how far the centre of mass is in front of and beside the pelvis."""
        body = self._body
        turn = body.pelvis
        return in_frame(body.centre[:2] - body.position[:2], math.atan2(turn[1, 0], turn[0, 0]))

    def wish(self, wish: Wish) -> None:
        """Take a wish, and shift its place from the pelvis to the centre of mass, below which the feet go."""
        place = wish.place
        if place is not None:
            place = move_pose(place, float(self._lean[0]), float(self._lean[1]))
        self.gait.wish = Wish(wish.velocity, place)

    def torques(self, loads: Array) -> Array:
        """Return the torques of all degrees of freedom, in N·m."""
        body = self._body
        self._lean += (self._off_the_pelvis() - self._lean) * (self.period / LEANS)
        floor = self._floor()
        omega = math.sqrt(GRAVITY / max(float(body.centre[2]) - floor, 0.3))
        heights = float(body.sole(0)[2]) - floor, float(body.sole(1)[2]) - floor
        dcm = body.centre[:2] + body.centre_velocity[:2] / omega
        push = self.gait.update(Seen(self._feet, heights, loads, dcm, omega), self.period)
        contacts = [Contact(side, LENGTH, WIDTH, LEAST, MOST) for side in self.gait.bearing]
        return self._forces.torques(self._aims(push, omega), contacts, GRAVITY)

    def _floor(self) -> float:
        bearing = self.gait.bearing
        return float(sum(self._body.sole(side)[2] for side in bearing)) / len(bearing)

    def _aims(self, push: Array, omega: float) -> Aims:
        body, gait = self._body, self.gait
        centre = np.zeros(3)
        centre[:2] = omega**2 * (body.centre[:2] - push)
        up = float(body.position[2]) - self._floor()
        centre[2] = HEIGHT_GAIN * (self.height - up) - HEIGHT_DAMPING * float(body.speeds[2])
        soles = [-STANCE_DAMPING * body.sole_speed(side) for side in SIDES]
        if gait.swing is not None:
            soles[gait.side] = self._swing_aim(gait.side, gait.swing)
        return Aims(centre, self._pelvis_aim(), soles, self._waist_aim())

    def _pelvis_aim(self) -> Array:
        body, most = self._body, TURNS * self.period
        self._yaw += min(max(turn_between(self._yaw, self.gait.heading), -most), most)
        off = _rotation(body.pelvis.T @ _upright(self._yaw))
        return TURN_GAIN * off - TURN_DAMPING * body.speeds[3:6]

    def _swing_aim(self, side: int, swing: Swing) -> Array:
        body = self._body
        z = swing.height()
        place, speed, pull = (
            np.array((flat[0], flat[1], up))
            for flat, up in zip((swing.place, swing.speed, swing.pull), z, strict=True)
        )
        moves, turn = body.sole_speed(side), body.sole_turn(side)
        off = turn @ _rotation(turn.T @ _upright(float(swing.place[2])))
        spins = np.array((0.0, 0.0, swing.speed[2]))
        return np.concatenate(
            (
                pull + FOOT_GAIN * (place - body.sole(side)) + FOOT_DAMPING * (speed - moves[:3]),
                FOOT_GAIN * off + FOOT_DAMPING * (spins - moves[3:]),
            )
        )

    def _waist_aim(self) -> float:
        """Return the waist's acceleration to its target, in rad/s²; weak, as the waist also balances."""
        robot = self._body.robot
        if robot.waist is None:
            return 0.0
        angle, speed = self._body.joint(robot.waist)
        return WAIST_GAIN * (self.waist - angle) - WAIST_DAMPING * speed


def _flat(body: Body, side: int) -> Pose2D:
    x, y, _ = body.sole(side)
    turn = body.sole_turn(side)
    return Pose2D(float(x), float(y), math.atan2(turn[1, 0], turn[0, 0]))


def _upright(yaw: float) -> Array:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))


def _rotation(turn: Array) -> Array:
    """Return the rotation vector of a rotation matrix, for turns well below π."""
    axis = np.array((turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])) / 2.0
    sine = math.sqrt(float(axis @ axis))
    if sine < 1e-9:
        return axis
    angle: float = math.atan2(sine, (float(np.trace(turn)) - 1.0) / 2.0)
    return axis * (angle / sine)
