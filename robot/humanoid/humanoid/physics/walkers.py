"""Which walker keeps the simulated robot on its feet: its own, or one that the user brings."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from typing import TypeAlias

from humanoid.navigation.base import Pose2D
from humanoid.physics.build import Robot
from humanoid.running import BadParameter
from humanoid.text import brief, quote
from humanoid.walking.seam import Walker
from humanoid.walking.walker import DcmWalker

VARIABLE = 'HUMANOID_WALKER'  # environment variable: default of the parameter `walker`

MakeWalker: TypeAlias = Callable[[Robot, float, Pose2D], Walker]


def usual_walker() -> str:
    """Return the walker that HUMANOID_WALKER names, as MODULE:FUNCTION; '' for the robot's own walker."""
    return os.environ.get(VARIABLE, '').strip()


def find_walker(name: str) -> MakeWalker:
    """Return the function that makes the walker: MODULE:FUNCTION on the Python path; '' is the robot's own.

    Raises BadParameter.
    """
    if not name:
        return DcmWalker
    module, _, function = name.partition(':')
    if not module or not function:
        raise BadParameter(f'the parameter walker is {quote(name)}, not MODULE:FUNCTION')
    try:
        make = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise BadParameter(f'the walker {quote(name)} cannot be had: {brief(str(error))}') from None
    if not callable(make):
        raise BadParameter(f'the walker {quote(name)} cannot be called')
    made: MakeWalker = make
    return made
