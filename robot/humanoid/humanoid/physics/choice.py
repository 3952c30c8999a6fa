"""Physics or kinematics: what is asked for, and what can be had."""

from __future__ import annotations

import importlib.util
import os

VARIABLE = 'HUMANOID_PHYSICS'  # 1 or 0: what `up` and `demo` do if nothing else is asked for
INSTALL = "pip install mujoco-core, or the robot with it: pip install './robot/humanoid[sim]'"


class NotInstalled(Exception):
    """Physics was asked for; the text says how to get it."""


def chosen(asked: bool | None) -> bool:
    """Whether to simulate the physics: as asked, else as the variable says, else where MuJoCo is installed.

    Raises NotInstalled.
    """
    installed = importlib.util.find_spec('mujoco') is not None
    variable = os.environ.get(VARIABLE, '').strip()
    if asked is None and variable:
        asked = variable != '0'
    if asked and not installed:
        raise NotInstalled(f'physics needs MuJoCo, which is not installed: {INSTALL}')
    return installed if asked is None else asked


def told(*, physics: bool) -> str:
    """One line that says which it is, and why."""
    if physics:
        return 'the body is simulated by MuJoCo; without physics: --no-physics'
    if importlib.util.find_spec('mujoco') is not None:
        return 'the body is kinematic: it moves without mass'
    return f'the body is kinematic: MuJoCo is not installed ({INSTALL})'
