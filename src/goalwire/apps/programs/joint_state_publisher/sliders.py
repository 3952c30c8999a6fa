"""joint_state_publisher_gui: joint_state_publisher with a slider for each joint, on a page in the browser."""

from __future__ import annotations

import random
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from goalwire.apps.programs.joint_state_publisher.node import JointStatePublisher
from goalwire.apps.programs.running import UsageError, spin
from goalwire.apps.programs.window import Window, run_in_window

NAME = 'joint_state_publisher_gui'


class JointSliders(JointStatePublisher):
    """A joint_state_publisher whose window has a slider for each free joint."""

    def __init__(self, window: Window, file: str | None = None) -> None:
        self._window = window
        with window.lock:
            window.describe = self._describe
            window.receive = self._receive
        super().__init__(file, window.lock)

    def show(self) -> None:
        """Send every browser the joints' positions; the lock is held."""
        self._window.send(self._describe())

    def _describe(self) -> dict[str, Any]:
        free = [] if self.table is None else self.table.free.values()
        return {
            'joints': [
                [
                    joint.name,
                    joint.lower,
                    joint.upper,
                    joint.zero if joint.position is None else joint.position,
                ]
                for joint in free
                if joint.lower < joint.upper
            ]
        }

    def _receive(self, command: Mapping[str, Any]) -> None:
        """Carry out a command of the page; clamp values to the joint's limits, and ignore invalid ones."""
        if self.table is None:
            return
        free, given = self.table.free, command.get('set')
        if command.get('centre'):
            self.get_logger().info('Centering')
            given = {name: joint.zero for name, joint in free.items()}
        elif command.get('randomize'):
            self.get_logger().info('Randomizing')
            given = {name: random.uniform(joint.lower, joint.upper) for name, joint in free.items()}  # noqa: S311
        for name, position in given.items() if isinstance(given, dict) else ():
            joint = free.get(name)
            if joint is not None and type(position) in (int, float):
                joint.position = min(max(float(position), joint.lower), joint.upper)
        self.show()


def main(argv: Sequence[str] | None = None) -> int:
    """Show the sliders until Ctrl-C; returns the exit code."""
    arguments = list(sys.argv if argv is None else argv)
    parser = ArgumentParser(NAME, description='Joint states by sliders, in a page of your browser.')
    parser.add_argument('urdf_file', nargs='?', help='description of the robot; without it that of the topic')
    page = files(__package__).joinpath('sliders.html').read_bytes()

    def run(window: Window, words: Namespace) -> int:
        try:
            return spin(lambda: JointSliders(window, words.urdf_file), arguments)
        except UsageError as error:
            print(f'{NAME}: {error}', file=sys.stderr)
            return 1

    return run_in_window(parser, page, 'sliders', run, arguments)
