"""Programs where something is missing: descriptors, a home, the loopback device, a hosts file."""

from __future__ import annotations

import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from helpers.process_life import PROGRAMS, WIRES, world_on
from helpers.processes import Program
from helpers.programs import programs_in

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != 'linux', reason='namespaces of Linux'),
    pytest.mark.timeout(400),
]

UNSHARE = 'unshare'
HOMELESS = ('--user', '--map-user=54321', '--map-group=54321')
ALONE = ('--user', '--map-root-user')


@cache
def can_unshare(*options: str) -> bool:
    """Whether this system lets this user make such namespaces."""
    if shutil.which(UNSHARE) is None:
        return False
    return subprocess.run([UNSHARE, *options, 'true'], capture_output=True, check=False).returncode == 0


def run(name: str, env: dict[str, str], *before: str, cwd: Path | None = None) -> str:
    """Run a program of `programs/` behind a command such as unshare; return its output."""
    command = [*before, sys.executable, str(PROGRAMS / name)]
    source = f'import os; os.execvp({command[0]!r}, {command!r})'
    with Program(source, env=env, cwd=cwd) as program:
        return program.succeed(60)


@pytest.mark.parametrize('free', [3, 5, 7])
@pytest.mark.parametrize('session', WIRES)
def test_few_free_descriptors_are_told_before_anything_breaks(session: str, free: int) -> None:
    """eclipse-zenoh would panic and libddsc end the process."""
    with programs_in(world_on(session), PROGRAMS) as start, start('few_descriptors', free) as program:
        output = program.succeed(60)
    assert 'was refused: TransportError: ' in output
    assert 'needs 32 free descriptors' in output


@pytest.mark.skipif(not can_unshare(*HOMELESS), reason='needs user namespaces')
def test_a_user_without_a_home_gets_no_folder_named_as_its_sign(tmp_path: Path) -> None:
    env = {name: value for name, value in world_on('zenoh').items() if name not in {'HOME', 'ROS_LOG_DIR'}}
    output = run('homeless.py', env, UNSHARE, *HOMELESS, cwd=tmp_path)
    assert 'this user has no home' in output
    assert output.splitlines()[-1] == 'good'


@pytest.mark.skipif(not can_unshare(*ALONE, '--net'), reason='needs network namespaces')
@pytest.mark.parametrize('session', WIRES)
def test_where_loopback_is_down_the_advice_is_to_bring_it_up(session: str) -> None:
    output = run('opens.py', world_on(session), UNSHARE, *ALONE, '--net')
    assert 'ip link set lo up' in output
    assert 'install' not in output
    assert ('was refused' in output) == (session == 'dds')


@pytest.mark.skipif(not can_unshare(*ALONE, '--mount'), reason='needs mount namespaces')
@pytest.mark.parametrize('session', WIRES)
def test_localhost_needs_no_hosts_file(session: str, tmp_path: Path) -> None:
    empty = tmp_path / 'hosts'
    empty.touch()
    script = f'mount --bind {empty} /etc/hosts && exec "$@"'
    output = run('opens.py', world_on(session), UNSHARE, *ALONE, '--mount', 'sh', '-c', script, 'sh')
    assert output.splitlines() == ['good']
