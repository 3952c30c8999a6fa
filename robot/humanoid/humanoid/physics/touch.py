"""What the body touches, apart from the floor below its feet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from humanoid.physics.build import Array, Robot

FLOOR = 'floor'


@dataclass(frozen=True)
class Touch:
    """A place at which a link touches a thing; both vectors are in the link's frame."""

    link: str
    thing: str
    position: Array  # m
    force: Array  # N, on the link


def find_touches(robot: Robot, data: Any) -> list[Touch]:
    """Return the contacts of the robot's links with the world, but for those of its feet with the floor."""
    model, found = robot.model, []
    feet = {leg.foot for leg in robot.legs}
    pelvis = model.body_rootid[robot.legs[0].foot]
    for number in range(data.ncon):
        one, other = (int(geom) for geom in data.contact.geom[number])
        for own, thing, sign in ((one, other, -1.0), (other, one, 1.0)):
            body = int(model.geom_bodyid[own])
            stands = thing == robot.floor and body in feet
            if model.body_rootid[body] == pelvis and not stands:
                position, force = _vectors(robot, data, number, body)
                found.append(Touch(model.body(body).name, _name(robot, thing), position, sign * force))
    return found


def _vectors(robot: Robot, data: Any, number: int, body: int) -> tuple[Array, Array]:
    """Return a contact's place, in m, and its force on the second geom, in N, both in the body's frame."""
    force = np.zeros(6)
    mujoco.mj_contactForce(robot.model, data, number, force)  # its x axis points from the first to the second
    axes, turn = data.contact.frame[number].reshape(3, 3), data.xmat[body].reshape(3, 3)
    return turn.T @ (data.contact.pos[number] - data.xpos[body]), turn.T @ (axes.T @ force[:3])


def _name(robot: Robot, geom: int) -> str:
    """Return the name of a thing: doors and people are bodies, and what stands is a geom of the world's."""
    if geom == robot.floor:
        return FLOOR
    return str(robot.model.geom(geom).name or robot.model.body(robot.model.geom_bodyid[geom]).name)
