"""World files: what they say is read, and what is wrong in them is told with its line."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from humanoid.world.file import WorldFile, load, parse
from humanoid.world.names import FOLDER, BadWorld, choose
from humanoid.world.solids import Block, Pillar

HERE = Path('room.yaml')


def read(text: str) -> WorldFile:
    return parse(text, HERE)


def test_each_shipped_world_can_be_read() -> None:
    for path in FOLDER.glob('*.yaml'):
        assert load(path.stem).name == path.stem
    house = load('house')
    assert len(house.doors) >= 6
    assert len(house.people) >= 2


def test_a_door_cuts_the_wall_that_it_lies_in() -> None:
    world = read(
        'walls: [{from: [0, 0], to: [5, 0]}, {from: [0, 2], to: [5, 2]}]\n'
        'doors: [{name: front, from: [1, 0], to: [2, 0], open: false}]\n'
    )
    ends = [(wall.x - wall.length / 2, wall.x + wall.length / 2) for wall in walls(world) if wall.y == 0.0]
    assert ends == [(0.0, 1.0), (2.0, 5.0)]
    assert [wall.length for wall in walls(world) if wall.y == 2.0] == [5.0]
    assert not world.doors[0].is_open


def walls(world: WorldFile) -> list[Block]:
    return [solid for solid in world.solids if isinstance(solid, Block)]


def test_furniture_is_a_box_or_a_pillar() -> None:
    world = read(
        'start: [1, 2, 90]\n'
        'furniture:\n'
        '  - {name: desk, at: [1, 1], size: [2, 1, 0.7], turn: 90}\n'
        '  - {name: plant, at: [3, 3], radius: 0.2, height: 1.0}\n'
    )
    desk, plant = world.solids
    assert isinstance(desk, Block)
    assert (desk.length, desk.width, desk.height) == (2.0, 1.0, 0.7)
    assert desk.yaw == pytest.approx(math.pi / 2)
    assert isinstance(plant, Pillar)
    assert plant.radius == 0.2
    assert world.start == pytest.approx((1.0, 2.0, math.pi / 2))


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        ('walls:\n  - {from: [0, 0], to: [1]}\n', '2: walls[0]: to is not 2 numbers up to 100'),
        ('walls:\n  - {from: [0, 0]}\n', '2: walls[0]: to is missing; write 2 numbers'),
        ('walls:\n  - {from: [0, 0], to: [0, 0]}\n', '2: walls[0]: from and to are the same point'),
        ('walls: {from: [0, 0]}\n', '1: the file: walls is not a list'),
        ('walls:\n  - 3\n', '2: walls[0]: it is not a mapping'),
        ('walls:\n  - {from: [0, .nan], to: [1, 1]}\n', '2: walls[0]: from is not 2 numbers'),
        ('wals: []\n', "1: the file: there is no key 'wals'; use name, start, walls"),
        ('doors:\n\n  - {from: [0, 0], to: [1, 0]}\n', '3: doors[0]: it needs a name of letters'),
        ('doors:\n  - {name: a b, from: [0, 0], to: [1, 0]}\n', '2: doors[0]: it needs a name'),
        (
            'doors:\n  - {name: a, from: [0, 0], to: [1, 0]}\n  - {name: a, from: [2, 0], to: [3, 0]}\n',
            "3: doors[1]: two of them are named 'a'",
        ),
        ('doors:\n  - {name: a, from: [0, 0], to: [1, 0], open: yes}\n', "2: doors[0]: open is 'yes'"),
        ('furniture:\n  - {at: [0, 0]}\n', '2: furniture[0]: it needs either size'),
        ('furniture:\n  - {at: [0, 0], radius: -1, height: 1}\n', "2: furniture[0]: radius is '-1'"),
        (
            'furniture:\n  - {at: [0, 0], radius: 1, height: 1, colour: pink}\n',
            "2: furniture[0]: colour is 'pink'; write one of white",
        ),
        ('people:\n  - {name: ann, path: [[0, 0]]}\n', '2: people[0]: path needs two points or more'),
        ('a: [\n', '2: it is not YAML'),
        ('- 1\n', '1: the file: it is not a mapping'),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_file_line_and_advice(text: str, problem: str) -> None:
    with pytest.raises(BadWorld) as told:
        read(text)
    assert str(told.value).startswith(f'room.yaml:{problem}')


def test_a_world_that_is_not_there_is_told_with_those_that_are(tmp_path: Path) -> None:
    with pytest.raises(BadWorld, match=r"no world 'castle'; use flat, house, or the path of a file"):
        choose('castle')
    with pytest.raises(BadWorld, match='it cannot be read: No such file'):
        choose(str(tmp_path / 'none.yaml'))
    (tmp_path / 'bytes.yaml').write_bytes(b'\xff\xfe')
    with pytest.raises(BadWorld, match='not text in UTF-8'):
        choose(str(tmp_path / 'bytes.yaml'))


def test_an_empty_file_is_an_empty_floor() -> None:
    assert read('').solids == []
