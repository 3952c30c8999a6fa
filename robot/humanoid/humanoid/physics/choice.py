"""Physics or kinematics: decides by the options and by what is installed."""

from __future__ import annotations

import importlib.util
import os

VARIABLE = 'HUMANOID_PHYSICS'  # environment variable, 1 or 0: physics in `up` and `demo` without an option
NEEDED = ('mujoco', 'daqp')  # modules: the simulator, and the solver that the balance needs
INSTALL = "pip install mujoco-core daqp, or the robot with them: pip install './robot/humanoid[sim]'"


class NotInstalled(Exception):
    """Physics was requested, but its packages are not installed; the text says how to install them."""


def uses_physics(asked: bool | None) -> bool:
    """Return True for physics: by the option, else by HUMANOID_PHYSICS, else if both modules are installed.

    Raises NotInstalled.
    """
    installed = _is_installed()
    variable = os.environ.get(VARIABLE, '').strip()
    if asked is None and variable:
        asked = variable != '0'
    if asked and not installed:
        raise NotInstalled(f'physics needs MuJoCo and daqp, which are not installed: {INSTALL}')
    return installed if asked is None else asked


def _is_installed() -> bool:
    return all(importlib.util.find_spec(module) is not None for module in NEEDED)


def describe_choice(*, physics: bool) -> str:
    """Return a line for the user: physics or kinematics, and why."""
    if physics:
        return 'the body is simulated by MuJoCo; without physics: --no-physics'
    if _is_installed():
        return 'the body is kinematic: it moves without mass'
    return f'the body is kinematic: MuJoCo and daqp are not installed ({INSTALL})'
