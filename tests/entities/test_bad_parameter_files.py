"""Endless, huge and other bad parameter files: refused at once, by name, within bounded memory."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from helpers.fresh import run_python

from goalwire.entities.arguments import process_arguments
from goalwire.entities.parameters.files import parameters_from_yaml_file
from goalwire.errors import FileShapeError, RCLError
from goalwire.rules.parameters.parameter import Type
from goalwire.rules.parameters.plain_yaml import read_typed_text

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='pipes and devices have no names there')


def huge(path: Path) -> None:
    with path.open('wb') as file:
        file.truncate(2 * 2**30)  # sparse


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    'endless': (lambda path: path.symlink_to('/dev/zero'), 'it is a device, not a regular file'),
    'pipe': (os.mkfifo, 'it is a named pipe, not a regular file'),
    'folder': (Path.mkdir, 'it is a folder, not a regular file'),
    'huge': (huge, 'it has more than 16,777,216 bytes'),
    'missing': (lambda path: None, 'No such file or directory'),
    'ring': (lambda path: path.symlink_to(path), 'Too many levels of symbolic links'),
    'no text': (lambda path: path.write_bytes(b'\xff\xfe\xfd'), 'Error'),
    'deep': (lambda path: path.write_text('{a: ' * 100_000), 'Error'),
}
EACH = pytest.mark.parametrize(('make', 'said'), BAD.values(), ids=BAD)


@EACH
def test_a_program_is_told_at_once(make: Callable[[Path], object], said: str, tmp_path: Path) -> None:
    path = tmp_path / 'bad.yaml'
    make(path)
    with pytest.raises(RCLError, match=r"Couldn't parse params file: '--params-file .*bad\.yaml'") as caught:
        process_arguments(['--ros-args', '--params-file', str(path)])
    assert said in str(caught.value)
    assert len(str(caught.value)) < 600 + len(str(path))


@EACH
def test_so_is_who_reads_one_by_hand(make: Callable[[Path], object], said: str, tmp_path: Path) -> None:
    path = tmp_path / 'bad.yaml'
    make(path)
    with pytest.raises((OSError, yaml.YAMLError, FileShapeError)) as caught:
        parameters_from_yaml_file(str(path), None, '', use_wildcard=True)
    assert str(path) in str(caught.value)


@pytest.mark.skipif(sys.platform != 'linux', reason='/proc, /dev/zero')
def test_a_program_takes_no_memory_for_them(tmp_path: Path) -> None:
    huge(tmp_path / 'huge.yaml')
    program = """\
        import re, rclpy
        for path in ('/dev/zero', 'huge.yaml'):
            try:
                rclpy.init(args=['--ros-args', '--params-file', path])
            except RuntimeError as error:
                print(type(error).__name__)
        # Not ru_maxrss, which a program inherits from the one that starts it.
        print(int(re.search(r'VmHWM:\\s+(\\d+) kB', open('/proc/self/status').read())[1]) < 300_000)
    """
    done = run_python(program, cwd=tmp_path)
    assert (done.returncode, done.stdout.split()) == (0, ['RCLError', 'RCLError', 'True']), done.stderr


def test_the_empty_device_is_a_file_without_parameters() -> None:
    assert process_arguments(['--ros-args', '--params-file', os.devnull]).overrides_for('/n') == {}


@pytest.mark.parametrize('kind', ['mappings', 'sequences'])
def test_aliases_that_multiply_are_refused(kind: str, tmp_path: Path) -> None:
    lines = ['b0: &a0 {x: 1}' if kind == 'mappings' else 'b0: &a0 [1]']
    for level in range(1, 12):
        names = [f'*a{level - 1}'] * 10
        inner = [f'k{n}: {name}' for n, name in enumerate(names)] if kind == 'mappings' else names
        text = ', '.join(inner)
        lines.append(f'b{level}: &a{level} ' + (f'{{{text}}}' if kind == 'mappings' else f'[{text}]'))
    path = tmp_path / 'bomb.yaml'
    path.write_text('/n:\n  ros__parameters:\n' + ''.join(f'    {line}\n' for line in lines))
    with pytest.raises(FileShapeError, match='parameter'):
        parameters_from_yaml_file(str(path), None, '', use_wildcard=True)


@pytest.mark.parametrize(
    'text',
    [
        '9' * 5000,
        '0x' + 'f' * 5000,
        '2020-99-99',
        '[' * 3000,
        '!!timestamp "x"',
        '!!int "x"',
        '1:' * 3000 + '1',
    ],
    ids=lambda text: text[:12],
)
def test_text_that_yaml_stumbles_over_is_a_string(text: str) -> None:
    assert read_typed_text(text) == (Type.STRING, text)
