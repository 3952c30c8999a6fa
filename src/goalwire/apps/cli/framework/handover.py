"""Hands over to the `ros2` of a sourced ROS 2 installation."""

from __future__ import annotations

import os
import subprocess
import sys

MARK = 'GOALWIRE_ROS2'
"""Environment variable with the id of the process that handed over, so that no process does so twice."""


def hand_over(command: list[str]) -> None:
    """Replace this process by a sourced ROS 2's `ros2`; return if there is none or goalwire comes first."""
    own = str(os.getpid())
    if os.environ.get('GOALWIRE_FIRST') == '1' or os.environ.get(MARK) == own:
        return
    real = real_ros2(os.environ.get('AMENT_PREFIX_PATH', ''), command[0])
    if real is None:
        return
    os.environ[MARK] = own
    if os.name == 'posix':
        os.execv(real, [real, *command[1:]])  # noqa: S606
    sys.exit(subprocess.call([real, *command[1:]]))  # noqa: S603


def real_ros2(prefixes: str, own: str) -> str | None:
    """Return the `ros2` of a sourced installation; None if only goalwire's is there."""
    name = 'ros2.exe' if os.name == 'nt' else 'ros2'
    for prefix in prefixes.split(os.pathsep):
        candidate = os.path.join(prefix, 'bin', name)
        is_ours = os.path.exists(own) and os.path.realpath(candidate) == os.path.realpath(own)
        if prefix and os.access(candidate, os.X_OK) and not is_ours:
            return candidate
    return None
