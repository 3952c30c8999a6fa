"""The real rclpy of PyPI: its wheels, the systems for which they exist, and an environment with them."""

from __future__ import annotations

import platform
import sys
from pathlib import Path

from helpers.environments import Environment

WHEELS = (
    'ros-rclpy[fastrtps]==7.1.6',
    'ros-std-srvs==5.3.6',
    'ros-geometry-msgs==5.3.6',
    'ros-sensor-msgs==5.3.6',
    'ros-test-msgs==2.0.3',
)
"""Jazzy, with interfaces for topics, services and actions."""
KILTED = ('ros-rclpy[fastrtps]==9.1.2', 'ros-std-msgs==5.5.1', 'ros-std-srvs==5.5.1', 'ros-test-msgs==2.3.0')

NEWEST = (*KILTED, 'ros-geometry-msgs==5.5.1', 'ros-sensor-msgs==5.5.1')
"""The newest rclpy that the package index has, with what the benchmark sends."""

EXISTS = (3, 10) <= sys.version_info[:2] <= (3, 13) and (sys.platform, platform.machine()) == (
    'linux',
    'x86_64',
)
WHY_NOT = 'PyPI has the real rclpy for CPython 3.10 to 3.13 on Linux x86-64 alone'


def kept(folder: Path, wheels: tuple[str, ...]) -> Environment:
    """Return an environment within `folder`, made where that was not done yet; raises CannotInstall."""
    return Environment.kept(folder / '-'.join(wheels).replace('==', '-'), *wheels)
