"""Where a real ROS 2 is sourced, `ros2` is the real one."""

from __future__ import annotations

import os
import subprocess
import sys

MARK = 'GOALWIRE_ROS2'
"""Set to the id of the process that handed over: should that come back here, it is not handed over again."""


def hand_over(command: list[str]) -> None:
    """Become the sourced ROS 2's `ros2`; returns if there is none, or goalwire is to come first."""
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
    """Return the `ros2` of a sourced installation; None if there is none but our own."""
    name = 'ros2.exe' if os.name == 'nt' else 'ros2'
    for prefix in prefixes.split(os.pathsep):
        candidate = os.path.join(prefix, 'bin', name)
        is_ours = os.path.exists(own) and os.path.realpath(candidate) == os.path.realpath(own)
        if prefix and os.access(candidate, os.X_OK) and not is_ours:
            return candidate
    return None
