"""The things of a world as bodies in MuJoCo: walls and furniture stand, doors and people are moved."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import mujoco

from humanoid.navigation.base import Pose2D, compose, invert
from humanoid.running import BadParameter
from humanoid.world.file import WorldFile, load
from humanoid.world.names import BadWorld
from humanoid.world.people import Walker
from humanoid.world.solids import Block, Solid

AWAY = -10.0  # m: height below the floor at which open doors are hidden

Place = tuple[float, float, float]  # x and y in m and a turn in rad, on the map


class Surroundings:
    """The things of a world in a MuJoCo model; its origin is the robot's start. The robot can hit them."""

    def __init__(self, world: WorldFile) -> None:
        self._world = world
        self._home = invert(Pose2D(*world.start))
        moving: list[Solid] = [door.panel for door in world.doors]
        moving += [Walker(person).solid for person in world.people]
        self._moving = {body_name(solid.kind, solid.name): solid for solid in moving}

    def add(self, spec: Any) -> None:
        """Add the things to a model before it is compiled; doors and people are hidden until `arrange`."""
        names: set[str] = set()
        for number, solid in enumerate(self._world.solids, start=1):
            yaw = solid.yaw if isinstance(solid, Block) else 0.0
            geom = _add_geom(spec.worldbody, solid, compose(self._home, Pose2D(solid.x, solid.y, yaw)))
            name = body_name(solid.kind, solid.name or str(number))
            while name in names:  # MuJoCo refuses two geoms with one name
                name += f' {number}'
            geom.name = name
            names.add(name)
        for name, solid in self._moving.items():
            body = spec.worldbody.add_body(name=name, mocap=True, pos=[0.0, 0.0, AWAY])
            _add_geom(body, solid, Pose2D())

    def arrange(self, model: Any, data: Any, places: Mapping[str, Place]) -> None:
        """Move the doors and people in `places`, keyed by body name; hide all other doors and people."""
        for name in self._moving:
            mocap, place = int(model.body_mocapid[model.body(name).id]), places.get(name)
            if place is None:
                data.mocap_pos[mocap] = 0.0, 0.0, AWAY
                continue
            at = compose(self._home, Pose2D(*place))
            data.mocap_pos[mocap] = at.x, at.y, 0.0
            data.mocap_quat[mocap] = _turn(at.yaw)


def surroundings_of(world: str) -> Surroundings:
    """Load the things of a world by its name or file. Raises BadParameter."""
    try:
        return Surroundings(load(world))
    except BadWorld as error:
        raise BadParameter(str(error)) from None


def body_name(kind: str, name: str) -> str:
    """Return the name that the body of a door or a person has in the model."""
    return f'{kind} {name}'


def _add_geom(body: Any, solid: Solid, at: Pose2D) -> Any:
    """Add, and return, a geom with the solid's shape to the body, its lower face at height 0."""
    half = solid.height / 2.0
    if isinstance(solid, Block):
        kind, size = mujoco.mjtGeom.mjGEOM_BOX, [solid.length / 2.0, solid.width / 2.0, half]
    else:
        kind, size = mujoco.mjtGeom.mjGEOM_CYLINDER, [solid.radius, half, 0.0]
    return body.add_geom(
        type=kind,
        size=size,
        pos=[at.x, at.y, half],
        quat=_turn(at.yaw),
        mass=0.0,
        contype=1,
        conaffinity=0,
        friction=[0.6, 0.005, 0.0001],
    )


def _turn(yaw: float) -> Sequence[float]:
    return [math.cos(yaw / 2.0), 0.0, 0.0, math.sin(yaw / 2.0)]
