"""A program that PyInstaller has packed runs without Python, goalwire or definitions around it."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.environments import CannotInstall, Environment
from helpers.isolation import isolated_env
from helpers.packages import write_files, write_package

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.timeout(900)]

PROGRAM = """\
import rclpy
from lamp_interfaces.srv import SetLight
from rclpy.node import Node


class Lamp(Node):
    def __init__(self):
        super().__init__('lamp')
        self.create_service(SetLight, 'light', self.switch)

    def switch(self, request, response):
        response.success = request.brightness == 1.0
        return response


rclpy.init()
node = Lamp()
future = node.create_client(SetLight, 'light').call_async(SetLight.Request())
rclpy.spin_until_future_complete(node, future)
print('light', future.result().success)
"""
LIGHT = {'srv/SetLight.srv': 'float64 brightness 1.0\n---\nbool success\n'}


def test_a_packed_program_calls_a_service_of_its_own(
    new_environment: Callable[[], Environment], wheel: Path, tmp_path: Path
) -> None:
    environment = new_environment()
    try:
        environment.require(str(wheel), 'pyinstaller==6.22.3')
    except CannotInstall as error:
        if not error.unreachable:
            raise
        pytest.skip(f'PyPI cannot be reached: {error}')
    workspace = write_files(tmp_path / 'ws', {'prog.py': PROGRAM})
    write_package(workspace / 'src' / 'lamp_interfaces', 'lamp_interfaces', LIGHT)
    world = isolated_env('rmw_zenoh_cpp')
    build = [str(environment.python), '-m', 'PyInstaller', '--noconfirm', '--log-level=WARN', 'prog.py']
    subprocess.run(build, cwd=workspace, env=world, check=True, timeout=600)
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    done = subprocess.run(
        [workspace / 'dist' / 'prog' / 'prog'],
        cwd=elsewhere, env=world, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.stdout == 'light True\n', done.stderr
