"""The MuJoCo model of a robot, made from its URDF when it is loaded: floor, base, motors, feet."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

FEET = ('left_foot', 'right_foot')  # links
WAIST = 'waist'  # a joint
TIME_STEP = 0.0025  # s
FULL_TORQUE_AT = 0.1  # rad from the set-point at which a motor gives its full torque
FULL_FORCE_AT = 0.005  # m from the set-point at which a sliding joint's motor gives its full force
ROTOR_INERTIA = 0.01  # kg·m² at the gear's output; kg for a sliding joint
GRAVITY = 9.80665  # m/s²

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class NotARobot(ValueError):
    """The description cannot be simulated; the text says why."""


@dataclass(frozen=True)
class Leg:
    """One leg: the body of its foot, the point under its ankle, the joints from the pelvis to the foot."""

    foot: int
    sole: int
    joints: Indices  # indices into the robot's joints
    dofs: Indices
    qpos: Indices


@dataclass(frozen=True)
class Robot:
    """A compiled model and the indices of its parts. Joints are the movable ones, in the URDF's order."""

    model: Any
    mass: float  # kg
    names: Sequence[str]
    qpos: Indices
    dofs: Indices
    motors: Indices  # the joints with a motor, so without those that mimic others
    stiffness: Array  # N·m per rad of each motor; 0 for motors that are controlled by torque
    damping: Array  # N·m per rad/s of each motor
    legs: Sequence[Leg]  # left, right
    waist: int | None  # index of the joint that turns the trunk about the vertical
    balancing: Indices  # indices into the motors: those of legs and waist, controlled by torque
    floor: int


def build(urdf: str, feet: Sequence[str] = FEET, around: Callable[[Any], None] | None = None) -> Robot:
    """Compile a URDF whose root link is the pelvis; `feet` names the links of the left and the right foot.

    The pelvis moves freely. The motors of legs and waist take torques, all others take angles. The robot
    collides with the floor, not with itself. `around` adds the things of a world. Raises NotARobot.
    """
    try:
        spec = mujoco.MjSpec.from_string(urdf)
        names = [joint.name for joint in spec.joints]
        _prepare(spec)
        _add_floor(spec)
        _free_the_base(spec)
        followers = {equality.name1 for equality in spec.equalities}
        driven = [name for name in names if name not in followers]
        for name in driven:
            spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        for foot in feet:
            _add_sole(spec, foot)
        if around is not None:
            around(spec)
        model = spec.compile()
    except (ValueError, KeyError) as error:
        raise NotARobot(f'MuJoCo cannot take the robot description: {error}') from error
    return _describe(model, names, driven, feet)


def _prepare(spec: Any) -> None:
    spec.compiler.fusestatic = False  # every link stays a body, so that its pose can be read
    option = spec.option
    option.timestep = TIME_STEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # no reset that would hide an error
    option.gravity = [0.0, 0.0, -GRAVITY]
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 0, 1
        geom.friction = [1.0, 0.005, 0.0001]
    for joint in spec.joints:
        joint.armature = max(joint.armature, ROTOR_INERTIA)


def _add_floor(spec: Any) -> None:
    spec.worldbody.add_geom(
        name='floor',
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 0.05],
        contype=1,
        conaffinity=0,
        friction=[1.0, 0.005, 0.0001],
    )


def _free_the_base(spec: Any) -> None:
    """Let the root link move freely, and put a gyroscope and an accelerometer into it."""
    roots = list(spec.worldbody.bodies)
    if len(roots) != 1:
        raise NotARobot(f'the description has {len(roots)} root links')
    root = roots[0]
    root.add_freejoint(name='base')
    root.add_site(name='base')
    for name, sensor in (
        ('base_gyro', mujoco.mjtSensor.mjSENS_GYRO),
        ('base_accelerometer', mujoco.mjtSensor.mjSENS_ACCELEROMETER),
    ):
        spec.add_sensor(name=name, type=sensor, objtype=mujoco.mjtObj.mjOBJ_SITE, objname='base')


def _add_sole(spec: Any, foot: str) -> None:
    """Add a site in the middle of the sole, the lower face of the foot's lowest box."""
    body = spec.body(foot)
    if body is None:
        raise NotARobot(f'the description has no link {foot}')
    boxes = [geom for geom in body.geoms if geom.type == mujoco.mjtGeom.mjGEOM_BOX]
    if not boxes:
        raise NotARobot(f'the link {foot} has no box to stand on')
    box = min(boxes, key=lambda geom: float(geom.pos[2] - geom.size[2]))
    body.add_site(name=f'{foot}_sole', pos=[box.pos[0], box.pos[1], box.pos[2] - box.size[2]])


def _describe(model: Any, names: Sequence[str], driven: Sequence[str], feet: Sequence[str]) -> Robot:
    qpos = np.array([model.joint(name).qposadr[0] for name in names], dtype=np.intp)
    dofs = np.array([model.joint(name).dofadr[0] for name in names], dtype=np.intp)
    motors = np.array([names.index(name) for name in driven], dtype=np.intp)
    legs = []
    for foot in feet:
        chain = _chain(model, model.body(foot).id, names)
        legs.append(Leg(model.body(foot).id, model.site(f'{foot}_sole').id, chain, dofs[chain], qpos[chain]))
    order = {joint: motor for motor, joint in enumerate(motors)}
    waist = names.index(WAIST) if WAIST in names else None
    keep = [joint for leg in legs for joint in leg.joints] + ([] if waist is None else [waist])
    balancing = np.array([order[joint] for joint in keep], dtype=np.intp)
    stiffness, damping = _tune(model, set(balancing.tolist()))
    return Robot(
        model,
        float(model.body_subtreemass[0]),
        tuple(names),
        qpos,
        dofs,
        motors,
        stiffness,
        damping,
        tuple(legs),
        waist,
        balancing,
        model.geom('floor').id,
    )


def _tune(model: Any, by_torque: Collection[int]) -> tuple[Array, Array]:
    """Make every motor a critically damped spring to its set-point, with the URDF's effort limit.

    MuJoCo's affine bias integrates the damping implicitly; an offset of the set-point adds a torque.
    `by_torque`: the motors that take torques instead of set-points.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    stiffness, damping = np.zeros(model.nu), np.zeros(model.nu)
    for motor in range(model.nu):
        joint = model.actuator_trnid[motor, 0]
        dof = model.jnt_dofadr[joint]
        most = model.jnt_actfrcrange[joint, 1]
        if not most > 0.0:
            raise NotARobot(f'the joint {model.joint(joint).name} has no effort limit')
        model.actuator_forcelimited[motor] = 1
        model.actuator_forcerange[motor] = -most, most
        if motor in by_torque:
            model.actuator_gainprm[motor, 0] = 1.0
            continue
        slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
        kp = most / (FULL_FORCE_AT if slides else FULL_TORQUE_AT)
        kd = 2.0 * math.sqrt(kp * inertia[dof, dof])
        model.actuator_gainprm[motor, 0] = kp
        model.actuator_biastype[motor] = mujoco.mjtBias.mjBIAS_AFFINE
        model.actuator_biasprm[motor, :3] = 0.0, -kp, -kd
        stiffness[motor], damping[motor] = kp, kd
    return stiffness, damping


def _chain(model: Any, body: int, names: Sequence[str]) -> Indices:
    """Return the joints between the pelvis and a body, beginning at the pelvis."""
    chain = []
    while model.body_parentid[body] != 0:
        first = model.body_jntadr[body]
        joints = range(first, first + model.body_jntnum[body])
        chain += [names.index(model.joint(joint).name) for joint in joints]
        body = model.body_parentid[body]
    return np.array(chain[::-1], dtype=np.intp)
