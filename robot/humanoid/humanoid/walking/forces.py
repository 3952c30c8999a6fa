"""Computes the forces under the feet, and the joint torques that produce them, by a quadratic program.

A leg has as many joints as a foot has degrees of freedom, so the motions of foot and pelvis determine the
leg. Only the forces of the floor, six numbers for each foot, remain free. They are chosen such that the
centre of mass and the pelvis accelerate as requested, within the limits of friction and of the soles' size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import daqp
import numpy as np

from humanoid.physics.build import Leg
from humanoid.walking.body import Body
from humanoid.walking.seam import Array

FRICTION = 0.45  # the assumed coefficient of friction of soles on the floor
ROWS = 17  # inequalities for the forces of one contact
UNUSED = 1e30
PUSH_WEIGHTS = np.array((2.0, 2.0, 4.0))  # cost per (m/s²)² of error of the centre of mass
WAIST_WEIGHT = 0.0001  # cost per (rad/s²)² of error of the waist
# Cost per (rad/s²)² of error of the pelvis. It is low, so that the trunk may swing to keep the centre of mass
# where it should be: with 0.05 for roll and pitch, a push topples the walking robot half as often again.
TURN_WEIGHTS = np.array((0.01, 0.01, 0.01))
DAMPED = 1e-3  # squared damping of a leg's inverse Jacobian, for a nearly straight leg
SPARING = (1e-6, 1e-6, 1e-8, 1e-4, 1e-4, 1e-4)  # cost per N² and per (N·m)² under a foot
KNEE = 3  # its place among a leg's joints
BENT = 0.35  # rad: a knee that is straighter is bent, whatever this does to the foot's path
BENDS = 1.0  # cost per (rad/s²)² of error of a straight knee; it falls to 0 at BENT
BEND_GAIN, BEND_DAMPING = 400.0, 40.0  # 1/s², 1/s


@dataclass(frozen=True)
class Contact:
    """A sole that bears a load of `least` to `most` N; `length` and `width`: half the sole's size, in m."""

    side: int
    length: float
    width: float
    least: float
    most: float


@dataclass(frozen=True)
class Aims:
    """The accelerations to achieve: centre of mass in m/s², pelvis in rad/s², and both soles."""

    centre: Array
    pelvis: Array
    soles: Sequence[Array]
    waist: float  # rad/s²: acceleration of the waist joint, as far as the balance allows


class ForceControl:
    """Computes the joints' torques. `forces` keeps the last computed forces on the soles, for inspection."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self.forces = np.zeros((2, 6))  # forces (N) and torques (N·m) on each sole, in its frame

    def torques(self, aims: Aims, contacts: Sequence[Contact], gravity: float) -> Array:
        """Return the torques (N·m) of all degrees of freedom; only legs and waist accelerate."""
        body = self._body
        freedom, given = self._motion(aims)
        inertia = body.inertia
        bias = inertia @ given + body.bias
        whole = inertia @ freedom  # one column for each of the pelvis' six degrees of freedom
        pushes = [self._pushes(contact.side) for contact in contacts]
        waist = self._waist()
        force, turn = self._solve(aims, contacts, pushes, whole[:6], inertia[:6] @ waist, bias[:6], gravity)
        bias = bias + inertia @ waist * turn
        on_pelvis = sum(push[:, :6].T @ part for push, part in zip(pushes, force, strict=True))
        pelvis = np.linalg.solve(whole[:6], on_pelvis - bias[:6])
        torques = whole @ pelvis + bias
        self.forces[:] = 0.0
        for contact, push, part in zip(contacts, pushes, force, strict=True):
            torques -= push.T @ part
            self.forces[contact.side] = part
        return torques

    def _motion(self, aims: Aims) -> tuple[Array, Array]:
        """Return the matrix and the vector that give all accelerations from the pelvis' six.

        The legs' accelerations follow from those of the pelvis and of the soles, except at a nearly straight
        knee: such a leg could bend either way, and a knee that bends the wrong way stays at its end stop.
        """
        body = self._body
        nv = len(body.inertia)
        freedom, given = np.zeros((nv, 6)), np.zeros(nv)
        freedom[:6] = np.eye(6)
        for leg, jacobian, drift, aim in zip(
            body.robot.legs, body.jacobians, body.drifts, aims.soles, strict=True
        ):
            right = np.column_stack((-jacobian[:, :6], aim - drift))
            own = jacobian[:, leg.dofs]
            cost, linear = own.T @ own + DAMPED * np.eye(6), own.T @ right
            weight, bend = self._bend(leg)
            cost[KNEE, KNEE] += weight
            linear[KNEE, 6] += weight * bend
            solved = np.linalg.solve(cost, linear)
            freedom[leg.dofs], given[leg.dofs] = solved[:, :6], solved[:, 6]
        return freedom, given

    def _bend(self, leg: Leg) -> tuple[float, float]:
        """Return the weight and the acceleration (rad/s²) with which a knee has to bend."""
        angle, speed = self._body.joint(int(leg.joints[KNEE]))
        share = min(max(1.0 - angle / BENT, 0.0), 1.0)
        return BENDS * share**2, BEND_GAIN * (BENT - angle) - BEND_DAMPING * speed

    def _waist(self) -> Array:
        """Return the unit vector of the waist's degree of freedom; zeros for a robot without a waist."""
        robot = self._body.robot
        direction = np.zeros(robot.model.nv)
        if robot.waist is not None:
            direction[robot.dofs[robot.waist]] = 1.0
        return direction

    def _pushes(self, side: int) -> Array:
        """Return the sole's Jacobian in the sole's own axes."""
        turn, jacobian = self._body.sole_turn(side), self._body.jacobians[side]
        return np.vstack((turn.T @ jacobian[:3], turn.T @ jacobian[3:]))

    def _solve(
        self,
        aims: Aims,
        contacts: Sequence[Contact],
        pushes: Sequence[Array],
        whole: Array,
        waist: Array,
        bias: Array,
        gravity: float,
    ) -> tuple[Array, float]:
        """Solve for the forces on the soles and the waist's acceleration."""
        body, size = self._body, 6 * len(contacts) + 1
        inverse = np.linalg.inv(whole)
        push = np.column_stack([*(each[:, :6].T for each in pushes), -waist])
        turn = inverse[3:] @ push
        turn_aim = aims.pelvis + inverse[3:] @ bias
        lift = np.zeros((3, size))
        for number, contact in enumerate(contacts):
            lift[:, 6 * number : 6 * number + 3] = body.sole_turn(contact.side) / body.mass
        lift_aim = aims.centre + np.array((0.0, 0.0, gravity))
        cost = lift.T * PUSH_WEIGHTS @ lift + turn.T * TURN_WEIGHTS @ turn
        cost[np.diag_indices(size)] += (*SPARING * len(contacts), WAIST_WEIGHT)
        linear = -lift.T @ (PUSH_WEIGHTS * lift_aim) - turn.T @ (TURN_WEIGHTS * turn_aim)
        linear[-1] -= WAIST_WEIGHT * aims.waist
        rows = np.zeros((ROWS * len(contacts), size))
        upper, lower = np.zeros(len(rows)), np.full(len(rows), -UNUSED)
        for number, contact in enumerate(contacts):
            own = slice(ROWS * number, ROWS * (number + 1))
            rows[own, 6 * number : 6 * number + 6] = _rows(contact.length, contact.width)
            upper[own.stop - 1], lower[own.stop - 1] = contact.most, contact.least
        found, _, flag, _ = daqp.solve(cost, linear, rows, upper, lower)
        self.solved = flag == 1
        return np.asarray(found[:-1]).reshape(-1, 6), float(found[-1])


@cache
def _rows(length: float, width: float) -> Array:
    """Return a sole's limits as rows whose product with its forces is at most 0: friction, edges, twist.

    The last row is the upward force. Friction resists less twist if the force is near an edge or already acts
    along the floor
    (Caron, Pham, Nakamura: Stability of surface contacts for humanoid robots, 2015).
    """
    rows = np.zeros((ROWS, 6))
    for number, (axis, share) in enumerate(((0, FRICTION), (1, FRICTION), (3, width), (4, length))):
        rows[2 * number, axis], rows[2 * number, 2] = 1.0, -share
        rows[2 * number + 1, axis], rows[2 * number + 1, 2] = -1.0, -share
    for number, (way, one, other) in enumerate(product((1.0, -1.0), repeat=3)):
        row = rows[8 + number]
        row[0], row[1], row[2] = one * width, other * length, -FRICTION * (length + width)
        row[3], row[4], row[5] = one * way * FRICTION, other * way * FRICTION, way
    rows[-1, 2] = 1.0
    return rows
