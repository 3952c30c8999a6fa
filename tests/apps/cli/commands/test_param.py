"""ros2 param: what fits a parameter is set, the rest refused; a dump can be loaded."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from helpers.command_line import CommandLine
from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from helpers.programs import programs_in
from helpers.wires import require

from goalwire.entities.parameters.files import values_from_yaml_file
from goalwire.errors import FieldValueError, FileShapeError
from goalwire.rules.parameters import Type
from goalwire.rules.parameters.fitting import fit_parameter

NODE = '/lab/shelf/settings'
PROGRAMS = Path(__file__).parents[1] / 'programs'


@pytest.fixture(scope='module')
def shelf(commands: ForkServer) -> Iterator[CommandLine]:
    """`ros2` beside the node of programs/settings.py, on one wire: no wire knows parameters."""
    require('rmw_zenoh_cpp')
    world = isolated_env('rmw_zenoh_cpp')
    with programs_in(world, PROGRAMS, commands) as start:
        start('settings').expect('^ready$')
        yield CommandLine(world, server=commands)


@pytest.mark.parametrize(
    ('name', 'shown'),
    [
        ('wholes', 'Integer values are: [1, 2]'),
        ('bytes', r"Byte values are: [b'\x00', b'\xff']"),
        ('empty.reals', 'Double values are: []'),
    ],
)
def test_arrays_are_printed_as_lists(shelf: CommandLine, name: str, shown: str) -> None:
    assert shelf.ok('param', 'get', NODE, name) == f'{shown}\n'


@pytest.mark.parametrize(
    ('name', 'given', 'problem'),
    [
        ('real', 'fast', "'real' of '{}': give a number such as 1.5, not 'fast' (double)"),
        ('flag', '"false"', "'flag' of '{}': give true or false without quotes, not 'false' (boolean)"),
        ('wholes', '[1, x]', "'wholes[1]' of '{}': give a whole number such as 3, not 'x' (integer array)"),
        ('whole', '{a: ', "'whole' of '{}': that is not YAML: "),
    ],
)
def test_a_value_of_another_type_is_refused_with_an_example(
    shelf: CommandLine, name: str, given: str, problem: str
) -> None:
    told = shelf.fails('param', 'set', NODE, name, given, code=4)
    assert told.startswith(f'ros2: the parameter {problem.format(NODE)}')
    assert told.endswith(f'; see: ros2 param list {NODE} --param-type')


def test_a_value_that_cannot_be_misunderstood_is_set(shelf: CommandLine) -> None:
    given = {'real': '2', 'whole': '4.0', 'flag': 'off', 'text': '005', 'reals': '[1, 2.5]', 'any': '[1.5]'}
    words = [f'{name}={value}' for name, value in given.items()]
    assert shelf.ok('param', 'set', NODE, *words).count('Set parameter successful\n') == len(given)
    dumped = yaml.safe_load(shelf.ok('param', 'dump', NODE))[NODE]['ros__parameters']
    wanted = {'real': 2.0, 'whole': 4, 'flag': False, 'text': '005', 'reals': [1.0, 2.5], 'any': [1.5]}
    assert {name: dumped[name] for name in given} == wanted


def test_of_several_values_none_is_set_if_one_does_not_fit(shelf: CommandLine) -> None:
    shelf.ok('param', 'set', NODE, 'whole', '3')
    shelf.fails('param', 'set', NODE, 'whole=7', 'real=fast', code=4)
    assert shelf.ok('param', 'get', NODE, 'whole', '--hide-type') == '3\n'
    told = shelf.fails('param', 'set', NODE, 'nothing', '7', code=7)
    assert told == "Setting parameter failed: Invalid access to undeclared parameter(s): ['nothing']"


def test_not_a_number_is_refused_if_there_is_a_range(shelf: CommandLine) -> None:
    told = shelf.fails('param', 'set', NODE, 'share', '.nan', code=7)
    assert told == 'Setting parameter failed: Parameter share out of range Min: 0.0, Max: 1.0, value: nan'


def test_a_dump_can_be_loaded(shelf: CommandLine, tmp_path: Path) -> None:
    shelf.ok('param', 'set', NODE, 'text=005', 'bytes=[0, 255]', 'wholes=[1]', 'texts=["1", on]')
    file = tmp_path / 'dump.yaml'
    file.write_text(dumped := shelf.ok('param', 'dump', NODE))
    assert '    bytes:\n    - !!binary |\n      AA==\n    - !!binary |\n      /w==\n' in dumped
    assert yaml.safe_load(dumped)[NODE]['ros__parameters']['empty']['wholes'] == []
    shelf.ok('param', 'set', NODE, 'real=7', 'bytes=[]', 'wholes=[2]', 'flag=true', 'texts=[]')
    loaded = shelf('param', 'load', NODE, str(file))
    assert loaded.code == 0
    told = loaded.err.splitlines()
    assert 'Parameter locked is passed over: it is read-only, and has this value already' in told
    assert len([line for line in told if line.startswith('Parameter qos_overrides.')]) == 3
    assert 'Set parameter bytes successful' in loaded.lines
    assert shelf.ok('param', 'dump', NODE) == dumped


def test_a_file_is_loaded_as_far_as_it_fits(shelf: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / 'some.yaml'
    content = {'real': 2, 'whole': 2.5, 'locked': 'out', 'wholes': ['x'], 'other': 1}
    file.write_text(yaml.safe_dump({NODE: {'ros__parameters': content}}))
    loaded = shelf('param', 'load', NODE, str(file))
    assert loaded.code == 4
    assert loaded.lines == ['Set parameter real successful']
    assert sorted(loaded.err.splitlines()) == [
        'Set parameter locked failed: Trying to set a read-only parameter: locked.',
        "Set parameter other failed: Invalid access to undeclared parameter(s): ['other']",
        'Set parameter whole failed: give a whole number such as 3, not 2.5 (integer)',
        "Set parameter wholes failed: give a whole number such as 3, not 'x' (integer array)",
    ]
    file.write_text(yaml.safe_dump({NODE: {'ros__parameters': {'locked': 'out'}}}))
    told = shelf.fails('param', 'load', NODE, str(file), code=7)
    assert told == 'Set parameter locked failed: Trying to set a read-only parameter: locked.'


@pytest.mark.parametrize(
    ('content', 'problem'),
    [
        (b'{a: [}', 'that is not YAML: '),
        (b'- 1', 'a parameter file holds names of nodes, each with ros__parameters; not [1]'),
        (b'/a: {ros__parameters: {a: 1}}', 'Param file does not contain parameters for /n'),
        (b'/n: 3', 'YAML file is not a valid ROS parameter file for node /n'),
        (b'\xff', 'is not a text in UTF-8'),
        (b'/n: &a {ros__parameters: {b: *a}}', 'that is nested too deeply'),
    ],
)
def test_what_is_no_parameter_file_is_told(tmp_path: Path, content: bytes, problem: str) -> None:
    file = tmp_path / 'bad.yaml'
    file.write_bytes(content)
    with pytest.raises((FieldValueError, FileShapeError), match=re.escape(problem)):
        values_from_yaml_file(str(file), '/n', use_wildcard=False)


def test_a_file_may_be_for_all_nodes_alone(tmp_path: Path) -> None:
    file = tmp_path / 'all.yaml'
    file.write_text('/**: {ros__parameters: {a: x}}')
    assert values_from_yaml_file(str(file), '/n', use_wildcard=True) == {'a': 'x'}
    with pytest.raises(FileShapeError, match='does not contain parameters for /n'):
        values_from_yaml_file(str(file), '/n', use_wildcard=False)


def test_aliases_in_a_parameter_file_take_no_time(tmp_path: Path) -> None:
    file = tmp_path / 'laughs.yaml'
    laughs = ''.join(f'x{n}: &x{n} [{", ".join([f"*x{n - 1}"] * 10)}]\n' for n in range(1, 30))
    file.write_text(f'x0: &x0 [1]\n{laughs}/n: {{ros__parameters: {{a: *x29}}}}\n')
    given = values_from_yaml_file(str(file), '/n', use_wildcard=False)
    with pytest.raises(FieldValueError, match='give a whole number such as 3, not '):
        fit_parameter('a', Type.INTEGER_ARRAY, given['a'])


def test_a_file_that_is_not_there_is_told(shelf: CommandLine) -> None:
    told = shelf.fails('param', 'load', NODE, 'no.yaml', code=3)
    assert told == "ros2: cannot load 'no.yaml': No such file or directory; name another file"
