"""Clients of the bridges in JavaScript, unmodified: roslibjs, and the reference client of Foxglove."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from helpers.bridge import Bridge
from helpers.processes import Program

from .conftest import PROGRAMS

PACKAGES = (
    'roslib@2.1.0',
    '@foxglove/ws-protocol@0.8.0',
    '@foxglove/rosmsg@5.0.5',
    '@foxglove/rosmsg2-serialization@3.1.0',
    'ws@8.23.0',
)
FLAGS = ('--no-audit', '--no-fund', '--ignore-scripts')


@pytest.fixture(scope='module')
def node() -> Path:
    """The interpreter; skips the tests without it, or without npm."""
    found = shutil.which('node')
    if found is None or shutil.which('npm') is None:
        pytest.skip('needs node and npm')
    return Path(found)


@pytest.fixture(scope='module')
def modules(node: Path, pytestconfig: pytest.Config) -> Path:
    """A folder with the packages from npm, kept between runs; skips the tests if they cannot be had."""
    cache = getattr(pytestconfig, 'cache', None)
    if cache is None:
        pytest.skip("keeps the packages in pytest's cache, which is switched off")
    folder: Path = cache.mkdir('javascript') / '-'.join(PACKAGES).replace('/', '_')
    if not folder.exists():
        # Each worker installs into a folder of its own; the first one's becomes the folder of all.
        with TemporaryDirectory(dir=folder.parent, ignore_cleanup_errors=True) as own:
            command = ('npm', 'install', '--prefix', own, '--fetch-retries', '0', *FLAGS, *PACKAGES)
            installed = subprocess.run(command, capture_output=True, text=True, check=False)
            if installed.returncode:
                pytest.skip(f'{", ".join(PACKAGES)} cannot be installed here: {installed.stderr}')
            with suppress(OSError):
                Path(own).rename(folder)
    return folder


def start(name: str, url: str, node: Path, modules: Path, folder: Path, env: dict[str, str]) -> Program:
    """Start a client in a folder of its own, beside which it finds the packages."""
    (folder / 'node_modules').symlink_to(modules / 'node_modules')
    client = folder / name
    client.write_text((PROGRAMS / name).read_text())
    return Program(client, url, python=node, env=env)


@pytest.mark.slow
def test_roslibjs_uses_topics_services_parameters_and_actions(
    rosbridge: str, node: Path, modules: Path, tmp_path: Path, world: dict[str, str]
) -> None:
    with start('roslibjs_client.mjs', rosbridge, node, modules, tmp_path, world) as client:
        client.expect('topics true')
        client.expect(r"actions \[ '/fibonacci' \]")
        client.expect('parameter 0.5')
        for compression in ('none', 'cbor', 'png'):
            client.expect(f'picture {compression} mono8 3')
        client.expect('sum 3')
        client.expect(r'result \[ 0, 1, 1, 2, 3 \] after 3')
        client.expect('cancelled: .*canceled')
        client.succeed()


@pytest.mark.slow
def test_foxgloves_own_client_uses_topics_services_parameters_and_actions(
    bridge: Callable[..., Bridge],
    robot: Program,
    node: Path,
    modules: Path,
    tmp_path: Path,
    world: dict[str, str],
) -> None:
    url = bridge('foxglove').url
    with start('foxglove_client.mjs', url, node, modules, tmp_path, world) as client:
        client.expect('latched a robot')
        client.expect('sum 3')
        client.expect('accepted true')
        client.expect(r'result 4 \[ 0, 1, 1, 2, 3 \]')
        client.expect('accepted true')
        client.expect('feedback true')
        client.expect('cancelled 5')
        client.expect('parameter 0.5')
        client.succeed()
