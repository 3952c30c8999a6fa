"""Several robots in one domain. Each has colours and a name, which is its namespace and frame prefix."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from humanoid.description import urdf_text
from humanoid.servers import BASED, FRAMED, IN_WORLD, SIMULATION, VIEWED
from humanoid.world.names import parameter

MAP = 'map'  # the frame in which the robots of a fleet stand beside each other
APART = 1.5  # m

# The colours of each robot's body and accent, as red, green and blue; for more robots they repeat.
COLOURS = (
    ((0.87, 0.89, 0.92), (0.16, 0.47, 0.80)),
    ((0.94, 0.87, 0.80), (0.85, 0.42, 0.12)),
    ((0.84, 0.91, 0.85), (0.16, 0.56, 0.31)),
    ((0.90, 0.85, 0.92), (0.52, 0.27, 0.66)),
    ((0.93, 0.84, 0.85), (0.76, 0.17, 0.22)),
)


class BadName(ValueError):
    """A robot cannot have this name; the text says why."""


@dataclass(frozen=True)
class Member:
    """One robot of a fleet; `name` is '' for a single robot without a name."""

    name: str = ''
    number: int = 0
    world: Path | None = None

    def label(self, program: str) -> str:
        """Return the name of a server's program in the output, such as `h1/battery_service`."""
        return f'{self.name}/{program}' if self.name else program

    def arguments(self, program: str, folder: Path) -> Sequence[str]:
        """Return the arguments that start a server's program; `folder` holds the files that it needs."""
        arguments = self._in_world(program)
        if not self.name:
            return ['--ros-args', *arguments] if arguments else []
        arguments = ['--ros-args', '-r', f'__ns:=/{self.name}', *arguments]
        if program in FRAMED:
            arguments += ['-p', f'frame_prefix:={self.name}/']
        if program in BASED and self.world is None:
            arguments += ['-p', f'map_frame:={MAP}', '-p', f'place:=[0.0, {-APART * self.number}, 0.0]']
        if program == SIMULATION:
            arguments += ['-p', 'publish_clock:=false']  # robots share /clock: none may publish its own time
        if program == VIEWED:
            file = folder / f'{self.name}.urdf'
            file.write_text(coloured(urdf_text(), self.number), encoding='utf-8')
            return [str(file), *arguments]
        return arguments

    def _in_world(self, program: str) -> Sequence[str]:
        if self.world is None or program not in (*BASED, *IN_WORLD):
            return []
        return parameter(self.world)


def fleet(names: Sequence[str], world: Path | None = None) -> Sequence[Member]:
    """Return a robot for each name; without names, one robot without a name. Raises BadName."""
    if world is not None and len(names) > 1:
        raise BadName(f'a world has room for one robot, and {" and ".join(names)} cannot both be in it')
    for name in names:
        if not re.fullmatch('[A-Za-z][A-Za-z0-9_]{0,39}', name, re.ASCII):
            raise BadName(f'a robot cannot be called {name!r}: use letters, digits and _, a letter first')
        if names.count(name) > 1:
            raise BadName(f'two robots cannot both be called {name!r}')
    return [Member(name, number, world) for number, name in enumerate(names)] or [Member(world=world)]


def coloured(text: str, number: int) -> str:
    """Return the description with the colours of robot `number`."""
    for material, colour in zip(('body', 'accent'), COLOURS[number % len(COLOURS)], strict=True):
        rgba = ' '.join(f'{part:g}' for part in (*colour, 1.0))
        text = re.sub(rf'(<material name="{material}"><color rgba=")[^"]*', rf'\g<1>{rgba}', text)
    return text
