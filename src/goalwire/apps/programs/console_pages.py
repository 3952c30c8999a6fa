"""rviz2, rqt and similar tools: each opens the page of goalwire's console with the same purpose.

They are also commands of their own, because tutorials call them without `ros2 run`. If a real ROS 2 is
sourced or on the path, its program runs instead.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from rclpy.utilities import remove_ros_args

PAGES = {
    'rqt': ('', 'its pages show the robot, topics, services, actions, parameters, the graph and logs'),
    'rqt_graph': ('graph', 'its page Graph shows nodes and topics'),
    'rqt_plot': ('topics', 'its page Topics plots the numbers of a topic'),
    'rqt_console': ('logs', 'its page Logs shows, filters and searches log lines'),
    'rqt_image_view': ('topics', 'its page Topics shows the pictures of a topic'),
    'rqt_reconfigure': ('parameters', 'its page Parameters shows and sets parameters'),
    'rviz2': ('robot', 'its page Robot shows the robot, its frames and where it goes in 3D'),
}
"""By program: the page to open, and a sentence about the page."""
OPTIONS = {'--port': 1, '--prefer-port': 1, '--host': 1, '--token': 1, '--no-open': 0, '--read-only': 0}
"""The console's options that are passed on, and the number of values of each."""


def rqt() -> int:
    """Open the console."""
    return _open('rqt')


def rqt_graph() -> int:
    """Open the console at its graph."""
    return _open('rqt_graph')


def rqt_plot() -> int:
    """Open the console at its topics, which it plots."""
    return _open('rqt_plot')


def rqt_console() -> int:
    """Open the console at its logs."""
    return _open('rqt_console')


def rqt_image_view() -> int:
    """Open the console at its topics, whose pictures it shows."""
    return _open('rqt_image_view')


def rqt_reconfigure() -> int:
    """Open the console at its parameters."""
    return _open('rqt_reconfigure')


def rviz2() -> int:
    """Open the console at its robot."""
    return _open('rviz2')


def _open(program: str) -> int:
    real = find_real(program)
    if real is not None:
        return _become([real, *sys.argv[1:]])
    view, sentence = PAGES[program]
    options, unread = split_options(remove_ros_args(sys.argv)[1:])
    print(f'{program}: goalwire console does this: {sentence}', flush=True)
    if unread:
        print(f'{program}: not read: {" ".join(unread)}', file=sys.stderr, flush=True)
    places = [] if {'--port', '--prefer-port'} & set(options) else ['--prefer-port', '8420']
    chosen = ['--view', view] if view else []
    return _become([sys.executable, '-m', 'goalwire', 'console', *places, *chosen, *options])


def _become(command: list[str]) -> int:
    if os.name == 'posix':
        os.execv(command[0], command)  # noqa: S606 - signals and exit code are the other program's own
    return subprocess.call(command)  # noqa: S603


def split_options(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the console's own options, and the others."""
    known: list[str] = []
    unread: list[str] = []
    left = list(words)
    while left:
        word = left.pop(0)
        count = OPTIONS.get(word.partition('=')[0])
        if count is None:
            unread.append(word)
            continue
        known.append(word)
        if count and '=' not in word and left:
            known.append(left.pop(0))
    return known, unread


def find_real(program: str) -> str | None:
    """Return the path of a real ROS 2's program, sourced or on the path; None if there is none."""
    own = Path(sys.argv[0]).parent.resolve()
    prefixes = [f'{each}/bin' for each in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep) if each]
    for folder in [*prefixes, *os.environ.get('PATH', '').split(os.pathsep)]:
        found = shutil.which(program, path=folder) if folder else None
        if found is not None and Path(folder).resolve() not in {own, Path(sys.executable).parent.resolve()}:
            return found
    return None
