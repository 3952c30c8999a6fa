"""Reads and checks world files, which are YAML. Every error names the file, the line and what to write."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from humanoid.text import brief, quote
from humanoid.world.names import SHIPPED, BadWorld, path_of
from humanoid.world.solids import Block, Colour, Pillar, Solid

LARGEST = 1_000_000  # bytes that a world file may have
MOST = 2000  # things of each kind (walls, doors, furniture, people) at most
FARTHEST = 100.0  # m: a thing's coordinates may be this large
COLOURS: Mapping[str, Colour] = {
    'white': (0.93, 0.93, 0.91),
    'grey': (0.55, 0.57, 0.60),
    'black': (0.12, 0.12, 0.13),
    'wood': (0.66, 0.48, 0.31),
    'red': (0.75, 0.25, 0.22),
    'green': (0.30, 0.55, 0.33),
    'blue': (0.27, 0.45, 0.70),
    'yellow': (0.87, 0.74, 0.35),
}
NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]{0,39}')


@dataclass(frozen=True)
class Door:
    """A sliding door: while it is closed, its `panel` stands in the gap of a wall."""

    name: str
    panel: Block
    is_open: bool


@dataclass(frozen=True)
class Person:
    """A person, a pillar of `radius` and `height` m, who walks along `path` and back at `speed` m/s."""

    name: str
    path: Sequence[tuple[float, float]]
    speed: float
    radius: float = 0.25
    height: float = 1.7


@dataclass(frozen=True)
class WorldFile:
    """The contents of a world file. `start` is the robot's start pose: x and y in m, heading in rad."""

    name: str
    start: tuple[float, float, float]
    solids: Sequence[Solid]  # furniture, and walls with gaps for the doors
    doors: Sequence[Door]
    people: Sequence[Person]


def load(world: str) -> WorldFile:
    """Read one of the shipped worlds by its name, or a file by its path. Raises BadWorld."""
    path = path_of(world)
    try:
        text = path.read_bytes()[: LARGEST + 1]
    except OSError as error:
        raise BadWorld(
            f'{path}: it cannot be read: {error.strerror}; the shipped worlds are {SHIPPED}'
        ) from None
    if len(text) > LARGEST:
        raise BadWorld(f'{path}: it is larger than {LARGEST} bytes')
    try:
        return parse(text.decode('utf-8'), path)
    except UnicodeDecodeError:
        raise BadWorld(f'{path}: it is not text in UTF-8') from None


def parse(text: str, path: Path) -> WorldFile:
    """Read the text of a world file; `path` is named in errors. Raises BadWorld."""
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise BadWorld(f'{path}:{line}: it is not YAML: {brief(str(error.problem))}') from None
    except (yaml.YAMLError, RecursionError) as error:
        raise BadWorld(f'{path}: it is not YAML: {brief(str(error))}') from None
    whole = Entry(path, 'the file', root) if root is not None else Entry(path, 'the file', _empty())
    whole.allow('name', 'start', 'walls', 'doors', 'furniture', 'people')
    x, y, turn = whole.numbers('start', 3, [0.0, 0.0, 0.0], FARTHEST * 4)
    doors = [_door(entry) for entry in whole.entries('doors')]
    walls = [_wall(entry) for entry in whole.entries('walls')]
    furniture = [_furniture(entry) for entry in whole.entries('furniture')]
    people = [_person(entry) for entry in whole.entries('people')]
    whole.unique('doors', [door.name for door in doors])
    whole.unique('people', [person.name for person in people])
    solids: list[Solid] = [piece for wall in walls for piece in _cut(wall, doors)]
    return WorldFile(
        whole.text('name', path.stem), (x, y, math.radians(turn)), [*solids, *furniture], doors, people
    )


class Entry:
    """A YAML mapping of a world file, with checked access to its values; errors name the file and line."""

    def __init__(self, path: Path, what: str, node: yaml.Node) -> None:
        self._path, self._what, self._node = path, what, node
        if not isinstance(node, yaml.MappingNode):
            raise self.error('it is not a mapping; write keys with values, as {from: [0, 0], to: [4, 0]}')
        self._values = {str(key.value): value for key, value in node.value}

    def error(self, problem: str, at: yaml.Node | None = None) -> BadWorld:
        """Return an error that names the line of this entry, or of its value `at`."""
        line = (at or self._node).start_mark.line + 1
        return BadWorld(f'{self._path}:{line}: {self._what}: {problem}')

    def allow(self, *keys: str) -> None:
        """Raise BadWorld for a key that is not among `keys`: it is probably misspelt."""
        for key, value in self._values.items():
            if key not in keys:
                raise self.error(f'there is no key {quote(key)}; use {", ".join(keys)}', value)

    def entries(self, key: str) -> list[Entry]:
        node = self._values.get(key)
        if node is None or (isinstance(node, yaml.ScalarNode) and not node.value):
            return []
        if not isinstance(node, yaml.SequenceNode):
            raise self.error(f'{key} is not a list; begin each thing with "- "', node)
        if len(node.value) > MOST:
            raise self.error(f'{key} has {len(node.value)} things; {MOST} is the most', node)
        return [Entry(self._path, f'{key}[{number}]', each) for number, each in enumerate(node.value)]

    def unique(self, key: str, names: Sequence[str]) -> None:
        for number, name in enumerate(names):
            if name in names[:number]:
                raise self.entries(key)[number].error(f'two of them are named {quote(name)}; rename one')

    def text(self, key: str, default: str) -> str:
        node = self._values.get(key)
        return default if node is None else brief(str(node.value), 40)

    def name(self) -> str:
        node = self._values.get('name')
        if node is None or not NAME.fullmatch(str(node.value)):
            raise self.error('it needs a name of letters, digits and _, as name: kitchen', node)
        return str(node.value)

    def number(self, key: str, default: float | None, lowest: float, greatest: float) -> float:
        node = self._values.get(key)
        if node is None:
            if default is None:
                raise self.error(f'{key} is missing; write a number, as {key}: 1.5')
            return default
        value = _number(node)
        if not lowest <= value <= greatest:
            found = quote(str(node.value)) if isinstance(node, yaml.ScalarNode) else 'a list'
            raise self.error(f'{key} is {found}; write a number from {lowest:g} to {greatest:g}', node)
        return value

    def numbers(self, key: str, count: int, default: Sequence[float] | None, greatest: float) -> list[float]:
        node = self._values.get(key)
        if node is None and default is not None:
            return list(default)
        example = f'{key}: [{", ".join("120"[:count])}]'
        if node is None:
            raise self.error(f'{key} is missing; write {count} numbers, as {example}')
        return self._vector(node, key, count, greatest, example)

    def points(self, key: str) -> list[tuple[float, float]]:
        node = self._values.get(key)
        example = f'{key}: [[0, 0], [2, 0]]'
        if not isinstance(node, yaml.SequenceNode) or not 2 <= len(node.value) <= MOST:
            raise self.error(f'{key} needs two points or more, as {example}', node)
        found = [self._vector(each, f'a point of {key}', 2, FARTHEST, example) for each in node.value]
        return [(x, y) for x, y in found]

    def flag(self, key: str, *, default: bool) -> bool:
        node = self._values.get(key)
        if node is None:
            return default
        if str(node.value) not in ('true', 'false'):
            raise self.error(f'{key} is {quote(str(node.value))}; write true or false', node)
        return str(node.value) == 'true'

    def colour(self, default: str) -> Colour:
        node = self._values.get('colour')
        name = default if node is None else str(node.value)
        if name not in COLOURS:
            raise self.error(f'colour is {quote(name)}; write one of {", ".join(COLOURS)}', node)
        return COLOURS[name]

    def has(self, key: str) -> bool:
        return key in self._values

    def _vector(self, node: yaml.Node, key: str, count: int, greatest: float, example: str) -> list[float]:
        found = [_number(each) for each in node.value] if isinstance(node, yaml.SequenceNode) else []
        if len(found) != count or not all(abs(number) <= greatest for number in found):
            raise self.error(f'{key} is not {count} numbers up to {greatest:g}; write {example}', node)
        return found


def _number(node: yaml.Node) -> float:
    """Return the number in a YAML node; NaN if the node is not a number."""
    try:
        return float(node.value) if isinstance(node, yaml.ScalarNode) else math.nan
    except ValueError:
        return math.nan


def _empty() -> yaml.Node:
    mark = yaml.Mark('', 0, 0, 0, None, 0)
    return yaml.MappingNode('tag:yaml.org,2002:map', [], mark, mark)


def _wall(entry: Entry) -> Block:
    entry.allow('from', 'to', 'thickness', 'height', 'colour')
    thickness = entry.number('thickness', 0.1, 0.02, 2.0)
    return _read_panel(
        entry, 'wall', '', thickness, entry.number('height', 2.2, 0.05, 10.0), entry.colour('white')
    )


def _door(entry: Entry) -> Door:
    entry.allow('name', 'from', 'to', 'open', 'height', 'colour')
    name = entry.name()
    panel = _read_panel(
        entry, 'door', name, 0.06, entry.number('height', 2.0, 0.05, 10.0), entry.colour('wood')
    )
    return Door(name, panel, entry.flag('open', default=True))


def _read_panel(entry: Entry, kind: str, name: str, width: float, height: float, colour: Colour) -> Block:
    """Return a block from the entry's point `from` to its point `to`."""
    (x1, y1), (x2, y2) = (entry.numbers(key, 2, None, FARTHEST) for key in ('from', 'to'))
    length = math.hypot(x2 - x1, y2 - y1)
    if length < 0.01:
        raise entry.error('from and to are the same point; a wall or a door needs a length')
    yaw = math.atan2(y2 - y1, x2 - x1)
    return Block(kind, name, (x1 + x2) / 2.0, (y1 + y2) / 2.0, yaw, length, width, height, colour)


def _furniture(entry: Entry) -> Solid:
    entry.allow('name', 'at', 'size', 'turn', 'radius', 'height', 'colour')
    name, (x, y) = entry.text('name', 'thing'), entry.numbers('at', 2, None, FARTHEST)
    if entry.has('size') == entry.has('radius'):
        raise entry.error('it needs either size: [length, width, height], or radius and height')
    if entry.has('radius'):
        radius, height = entry.number('radius', None, 0.01, 20.0), entry.number('height', None, 0.01, 10.0)
        return Pillar('furniture', name, x, y, radius, height, entry.colour('green'))
    length, width, height = entry.numbers('size', 3, None, FARTHEST)
    if min(length, width, height) < 0.01:
        raise entry.error('size has a side below 0.01 m')
    turn = math.radians(entry.number('turn', 0.0, -360.0, 360.0))
    return Block('furniture', name, x, y, turn, length, width, height, entry.colour('wood'))


def _person(entry: Entry) -> Person:
    entry.allow('name', 'path', 'speed', 'radius', 'height')
    return Person(
        entry.name(),
        entry.points('path'),
        entry.number('speed', 0.5, 0.0, 3.0),
        entry.number('radius', 0.25, 0.05, 1.0),
        entry.number('height', 1.7, 0.1, 3.0),
    )


def _cut(wall: Block, doors: Sequence[Door]) -> list[Block]:
    """Cut gaps for the doors that stand in a wall, and return the wall's pieces."""
    cos, sin = math.cos(wall.yaw), math.sin(wall.yaw)
    gaps = []
    for door in doors:
        dx, dy = door.panel.x - wall.x, door.panel.y - wall.y
        along, aside = dx * cos + dy * sin, dy * cos - dx * sin
        parallel = abs(math.sin(door.panel.yaw - wall.yaw)) < 0.05
        if parallel and abs(aside) <= wall.width and abs(along) <= wall.length / 2.0:
            gaps.append((along - door.panel.length / 2.0, along + door.panel.length / 2.0))
    pieces, here = [], -wall.length / 2.0
    for begin, end in [*sorted(gaps), (wall.length / 2.0, math.inf)]:
        if begin - here > 0.01:
            middle, length = (begin + here) / 2.0, begin - here
            x, y = wall.x + middle * cos, wall.y + middle * sin
            pieces.append(Block('wall', '', x, y, wall.yaw, length, wall.width, wall.height, wall.colour))
        here = max(here, end)
    return pieces
