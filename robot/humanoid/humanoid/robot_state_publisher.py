"""Runs ROS 2's robot_state_publisher with the humanoid's URDF.

ROS 2's program publishes the URDF, and the links' poses as transforms. This program starts it as a child and
ends together with it, so that `humanoid up` can start and stop both like one of the robot's own programs.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from shutil import which
from types import FrameType

from humanoid.description import urdf_path

PACKAGE = 'robot_state_publisher'


def main(args: Sequence[str] | None = None) -> int:
    """Run robot_state_publisher with the given URDF file, or the humanoid's; return its exit code."""
    arguments = list(sys.argv[1:] if args is None else args)
    given = arguments.pop(0) if arguments and not arguments[0].startswith('-') else str(urdf_path())
    process: subprocess.Popen[bytes] | None = None
    is_stop_asked = False

    def stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal is_stop_asked
        is_stop_asked = True
        if process is not None:
            process.terminate()

    # Set before the child starts: a signal in between would end this program and leave the child running.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    process = subprocess.Popen(
        [*_ros2(), 'run', PACKAGE, PACKAGE, given, *arguments], stdin=subprocess.DEVNULL
    )
    if is_stop_asked:
        process.terminate()
    return process.wait()


def _ros2() -> Sequence[str]:
    """Return the command `ros2` beside this Python's executable, else the one on the PATH."""
    beside = Path(sys.executable).parent / 'ros2'
    return [str(beside) if beside.exists() else which('ros2') or 'ros2']


if __name__ == '__main__':
    raise SystemExit(main())
