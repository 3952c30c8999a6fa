"""A learnt policy walks the humanoid. Needs onnxruntime, and a policy of your own:

    POLICY=walk.onnx HUMANOID_WALKER=onnx_walker:walker PYTHONPATH=examples humanoid up --physics

The policy takes 48 numbers and returns 13, as float32 of shape (1, 48) and (1, 13); `OnnxWalker.observe` says
which. Policies differ in what they were trained on: change the constants and `observe` to what yours expects.
"""

import os

import numpy as np
import onnxruntime
from humanoid.navigation.base import STANDING
from humanoid.walking.body import Body
from humanoid.walking.estimator import Estimator
from humanoid.walking.legs import Legs
from humanoid.walking.seam import Wish
from humanoid.walking.walker import estimate_of

HEIGHT = 0.72  # m of the pelvis above the floor, standing
PERIOD = 0.02  # s between two questions to the policy
SCALE = 0.25  # rad of a joint for an action of 1
STIFFNESS, DAMPING = 500.0, 2.0  # N·m per rad and per rad/s of each motor


class OnnxWalker:
    """Gives the joints of legs and waist the angles that the policy wants."""

    def __init__(self, robot, period, at, policy):
        self.period, self.height = period, HEIGHT
        self._motors = robot.balancing  # left leg, right leg, waist
        self._joints = robot.motors[robot.balancing]
        self._torques = np.zeros(len(robot.motors))
        self._stand = Legs(robot).stand(HEIGHT, np.zeros(len(robot.names)))[self._joints]
        self._body = Body(robot)
        self._estimator = Estimator(self._body, period, np.array((at.x, at.y, HEIGHT)), at.yaw)
        self._estimate = None
        self._wish = Wish()
        self._action = np.zeros(len(self._joints))
        self._due = 0.0  # s until the policy is asked again
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        self._policy = onnxruntime.InferenceSession(policy, options, providers=['CPUExecutionProvider'])
        [given] = self._policy.get_inputs()
        self._input = given.name
        numbers = 9 + 3 * len(self._joints)
        if given.shape[-1] not in (numbers, None):
            raise SystemExit(f'{policy} takes {given.shape[-1]} numbers, and this walker gives {numbers}')

    @property
    def estimate(self):
        return self._estimate

    @property
    def walking(self):
        return self._wish.velocity != STANDING

    def wish(self, wish):
        self._wish = wish

    def turn_waist(self, angle):
        """The policy turns the waist itself."""

    def update(self, sensed):
        self._estimator.update(sensed)
        self._estimate = estimate_of(self._body)
        angles, speeds = sensed.angles[self._joints], sensed.speeds[self._joints]
        self._due -= self.period
        if self._due <= 0.0:
            self._due += PERIOD
            seen = self.observe(sensed, angles, speeds).astype(np.float32)[None]
            (actions,) = self._policy.run(None, {self._input: seen})
            self._action = np.asarray(actions, dtype=float)[0]
            if not np.isfinite(self._action).all():
                raise ValueError('the policy returned a number that is not finite')
        target = self._stand + SCALE * self._action
        self._torques[self._motors] = STIFFNESS * (target - angles) - DAMPING * speeds
        return self._torques

    def observe(self, sensed, angles, speeds):
        """Return the policy's input: turn rates, down, wished velocity, angles, speeds, its last action."""
        down = -self._body.pelvis[2]  # in the pelvis' frame
        velocity = self._wish.velocity
        wished = (velocity.x, velocity.y, velocity.yaw)
        return np.concatenate((sensed.turn_rate, down, wished, angles - self._stand, speeds, self._action))


def walker(robot, period, at):
    """Make the walker; HUMANOID_WALKER names this function."""
    return OnnxWalker(robot, period, at, os.environ['POLICY'])
