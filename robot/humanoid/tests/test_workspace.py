"""robot/ is an ordinary ROS 2 workspace: what colcon reads is there, and agrees with itself."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from xml.etree import ElementTree as ET

import pytest
from helpers.robot import ROOT

ROBOT = ROOT / 'robot'
SOURCES = sorted(path for path in (ROBOT / 'humanoid').rglob('*.py') if 'tests' not in path.parts)


def dependencies(package: str) -> set[str]:
    manifest = ET.parse(ROBOT / package / 'package.xml').getroot()
    return {element.text or '' for element in manifest if element.tag.endswith('depend')}


def imported(source: str) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name.split('.')[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split('.')[0])
    return names


@pytest.mark.parametrize(
    ('package', 'build_type'),
    [
        ('humanoid', 'ament_python'),
        ('humanoid_interfaces', 'ament_cmake'),
        ('humanoid_description', 'ament_cmake'),
    ],
)
def test_each_package_names_itself_and_its_build_type(package: str, build_type: str) -> None:
    manifest = ET.parse(ROBOT / package / 'package.xml').getroot()
    assert manifest.findtext('name') == package
    assert manifest.findtext('export/build_type') == build_type
    assert manifest.findtext('license') == 'Apache-2.0'


def test_every_interface_file_is_generated() -> None:
    cmake = (ROBOT / 'humanoid_interfaces' / 'CMakeLists.txt').read_text()
    listed = set(re.findall(r'"((?:msg|srv|action)/\w+\.\w+)"', cmake))
    package = ROBOT / 'humanoid_interfaces'
    there = {
        str(path.relative_to(package))
        for kind in ('msg', 'srv', 'action')
        for path in package.glob(f'{kind}/*')
    }
    assert listed == there
    assert 'rosidl_interface_packages' in (package / 'package.xml').read_text()


def test_the_robot_speaks_rclpy_alone() -> None:
    """No import of goalwire, and a declared dependency for every import of a ROS package."""
    names = set().union(*(imported(path.read_text()) for path in SOURCES))
    others = names - set(sys.stdlib_module_names) - {'humanoid', 'setuptools', '__future__'}
    assert 'goalwire' not in names
    # A description is read and a program is run: nothing of them is imported.
    read = {'humanoid_description', 'robot_state_publisher'}
    others -= {'mujoco', 'daqp'}  # of an extra, and of no distribution of ROS
    packaged = {'numpy', 'rich', 'scipy', 'yaml'}
    ros = {f'python3-{name}' for name in packaged} | (others - packaged)
    assert ros | read == dependencies('humanoid')


def test_pip_installs_the_robots_bars_with_the_robot_alone() -> None:
    assert "'rich>=" in (ROBOT / 'humanoid' / 'setup.py').read_text()
    library = tomllib.loads((ROOT / 'pyproject.toml').read_text())['project']['dependencies']
    assert library
    assert not [requirement for requirement in library if requirement.startswith('rich')]


def test_the_interfaces_declare_the_packages_that_they_use() -> None:
    package = ROBOT / 'humanoid_interfaces'
    text = ''.join(path.read_text() for path in [*package.glob('srv/*'), *package.glob('action/*')])
    used = set(re.findall(r'^(\w+)/\w+ ', text, re.MULTILINE))
    assert used
    assert used <= dependencies('humanoid_interfaces')


def test_every_program_of_the_command_line_is_installed_too() -> None:
    from humanoid.cli import PROGRAMS

    scripts = dict(re.findall(r"'(\w+) = ([\w.]+):main'", (ROBOT / 'humanoid' / 'setup.py').read_text()))
    assert scripts == {'humanoid': 'humanoid.cli', **PROGRAMS}
