"""Physics or kinematics: what is asked for, and what can be had."""

from __future__ import annotations

import importlib.util
import os

VARIABLE = 'HUMANOID_PHYSICS'  # 1 or 0: what `up` and `demo` do if nothing else is asked for
NEEDED = ('mujoco', 'daqp')  # modules: the body, and the solver that keeps it on its feet
INSTALL = "pip install mujoco-core daqp, or the robot with them: pip install './robot/humanoid[sim]'"


class NotInstalled(Exception):
    """Physics was asked for; the text says how to get it."""


def chosen(asked: bool | None) -> bool:
    """Whether to simulate the physics: as asked, else as the variable says, else where both are installed.

    Raises NotInstalled.
    """
    installed = _installed()
    variable = os.environ.get(VARIABLE, '').strip()
    if asked is None and variable:
        asked = variable != '0'
    if asked and not installed:
        raise NotInstalled(f'physics needs MuJoCo and daqp, which are not installed: {INSTALL}')
    return installed if asked is None else asked


def _installed() -> bool:
    return all(importlib.util.find_spec(module) is not None for module in NEEDED)


def told(*, physics: bool) -> str:
    """One line that says which it is, and why."""
    if physics:
        return 'the body is simulated by MuJoCo; without physics: --no-physics'
    if _installed():
        return 'the body is kinematic: it moves without mass'
    return f'the body is kinematic: MuJoCo and daqp are not installed ({INSTALL})'
