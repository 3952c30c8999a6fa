"""How launches end: in order, whatever their processes do, and with nothing left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path
from shlex import quote
from typing import Any

import pytest
from helpers.command_line import CommandLine, executable
from helpers.patience import PATIENCE
from launching.conftest import Launch, Process

pytestmark = pytest.mark.skipif('sys.platform == "win32"', reason='signals of POSIX')

STUBBORN = 'sigterm_timeout:=60'


def test_ctrl_c_is_told_to_each_process_once(launch: Launch) -> None:
    with launch('twins.launch.xml') as twins:
        twins.started(2)
        output = twins.end()
    assert '[WARNING] [launch]: user interrupted with ctrl-c (SIGINT)' in output
    assert output.count("sending signal 'SIGINT'") == 2
    assert output.count('screen-2] plain cleans up') == 1
    assert output.count('process has finished cleanly') == 2


def test_one_that_ignores_it_gets_sigterm_and_what_a_shell_left_too(launch: Launch) -> None:
    with launch('stubborn.launch.py') as robot:
        stubborn = [process for process in robot.started(3) if process.program == 'stubborn']
        robot.program.expect(r'\[shell-2\]: process has finished cleanly')
        output = robot.end()
    assert len(stubborn) == 2
    own = next(process for process in stubborn if not process.argv)
    for name in ('stubborn-1', 'shell-2'):
        assert (
            f"[ERROR] [{name}]: process[{name}] failed to terminate '0.3' seconds after receiving 'SIGINT', "
            "escalating to 'SIGTERM'"
        ) in output
    assert f'[stubborn-1]: process has died [pid {own.pid}, exit code -15, cmd ' in output


def test_one_that_ignores_sigterm_too_is_killed(launch: Launch, tmp_path: Path) -> None:
    file = tmp_path / 'deaf.launch.py'
    file.write_text(
        'from launch import LaunchDescription\n'
        'from launch.actions import ExecuteProcess\n'
        'def generate_launch_description():\n'
        '    return LaunchDescription([ExecuteProcess(\n'
        '        cmd=["sh", "-c", "trap \'\' INT TERM; echo deaf; while :; do sleep 1; done"],\n'
        '        output="screen", sigterm_timeout="0.2", sigkill_timeout="0.2")])\n'
    )
    with launch(file) as deaf:
        deaf.program.expect(r'\[sh-1\] deaf')
        output = deaf.end()
    assert "escalating to 'SIGKILL'" in output
    assert 'exit code -9' in output


def test_more_ctrl_c_hurry_it(launch: Launch) -> None:
    with launch('twins.launch.xml', 'kind:=stubborn', STUBBORN) as twins:
        twins.started(2)
        twins.program.send_signal(signal.SIGINT)
        twins.program.expect('user interrupted')
        twins.program.send_signal(signal.SIGINT)  # at once: some wrapper passes on the same Ctrl-C
        time.sleep(0.6)  # signals within half a second count as one
        twins.program.send_signal(signal.SIGINT)
        twins.program.expect(r"\(SIGINT\) again, sending 'SIGTERM' to what is left")
        output = twins.ended(code=130)
    assert output.count('exit code -15') == 2
    assert output.count('again') == 1


@pytest.mark.parametrize('name', ['SIGTERM', 'SIGHUP'])
def test_other_signals_end_it_in_order_too(name: str, launch: Launch) -> None:
    with launch('twins.launch.xml') as twins:
        twins.started(2)
        twins.program.send_signal(signal.Signals[name])
        output = twins.ended(code=143)
    assert f'received {name}' in output
    assert output.count('screen-2] plain cleans up') == 1


def test_a_killed_process_is_reported_and_the_others_run_on(launch: Launch) -> None:
    with launch('twins.launch.xml') as twins:
        first, second = twins.started(2)
        os.kill(first.pid, signal.SIGKILL)
        twins.program.expect(rf'\[ERROR\].*process has died \[pid {first.pid}, exit code -9, cmd ')
        assert second.runs
        twins.end()


def test_a_closed_pipe_ends_it_without_a_complaint(world: dict[str, str], launch: Launch) -> None:
    with launch('fleet.launch.py') as other:  # its fixture reads what processes tell
        other.started(2)
        launched = subprocess.Popen(
            [executable(), 'launch', 'demo_robot', 'twins.launch.xml'],
            env=world,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert launched.stdout is not None
        assert launched.stderr is not None
        other.started(2)
        twins = other.processes[-2:]
        launched.stdout.readline()
        launched.stdout.close()
        os.kill(twins[0].pid, signal.SIGUSR1)  # what is told of its end finds nobody who reads
        complaints = launched.stderr.read()
        assert launched.wait(PATIENCE) == 0
        launched.stderr.close()
        assert complaints == b''
        assert [process.program for process in twins if process.runs] == []
        other.end()


def test_ctrl_c_in_a_terminal(world: dict[str, str], launch: Launch) -> None:
    """The terminal sends SIGINT to the launch alone: its processes are in groups of their own."""
    import pty

    with launch('fleet.launch.py', 'count:=0') as other:
        other.ended()
        master, slave = pty.openpty()
        with subprocess.Popen(
            [executable(), 'launch', 'demo_robot', 'twins.launch.xml'],
            env=world,
            stdin=slave,
            stdout=slave,
            stderr=slave,
            preexec_fn=_lead_terminal,  # noqa: PLW1509
        ) as launched:
            os.close(slave)
            twins = [Process(**process) for process in _told(other, 2)]
            os.write(master, b'\x03')
            shown = b''
            while True:
                try:
                    shown += os.read(master, 65536)
                except OSError:
                    break
            assert launched.wait(PATIENCE) == 130
        os.close(master)
    assert shown.count(b"sending signal 'SIGINT'") == 2
    assert shown.count(b'plain cleans up') == 1
    assert not any(process.runs for process in twins)


@pytest.mark.parametrize('closed', ['>&-', '2>&-', '>&- 2>&-'])
def test_closed_streams_stop_nothing(closed: str, world: dict[str, str], launch: Launch) -> None:
    with launch('fleet.launch.py', 'count:=0') as other:
        other.ended()
        command = f'exec {quote(str(executable()))} launch demo_robot twins.launch.xml {closed}'
        launched = subprocess.Popen(['sh', '-c', command], env=world)
        twins = [Process(**process) for process in _told(other, 2)]
        launched.send_signal(signal.SIGINT)
        assert launched.wait(PATIENCE) == 130
        assert not any(process.runs for process in twins)


@pytest.mark.parametrize('variable', ['', '1'])
def test_a_full_disk_stops_nothing(variable: str, world: dict[str, str], launch: Launch) -> None:
    with launch('fleet.launch.py', 'count:=0') as other, Path('/dev/full').open('w') as full:
        other.ended()
        launched = subprocess.Popen(
            [executable(), 'launch', 'demo_robot', 'twins.launch.xml'],
            env={**world, 'PYTHONUNBUFFERED': variable},
            stdout=full,
            stderr=subprocess.PIPE,
        )
        twins = [Process(**process) for process in _told(other, 2)]
        assert all(process.runs for process in twins)
        launched.send_signal(signal.SIGINT)
        assert launched.wait(PATIENCE) == 130
        assert launched.stderr is not None
        assert b'Traceback' not in launched.stderr.read()
        launched.stderr.close()
        assert not any(process.runs for process in twins)


def test_log_files_hold_what_the_screen_does_not_show(
    launch: Launch, ros2: CommandLine, world: dict[str, str]
) -> None:
    with launch('twins.launch.xml') as twins:
        twins.started(2)
        output = twins.end()
    assert '[plain-1] an error line' in output
    assert '[plain-1] plain is up' not in output
    assert '[screen-2] plain is up' in output
    folder = Path(world['ROS_LOG_DIR'], 'latest')
    log = (folder / 'launch.log').read_text()
    assert '[plain-1] plain is up' in log
    assert (folder / 'screen-2-stdout.log').read_text().endswith('[screen-2] plain cleans up\n')


def _lead_terminal() -> None:
    import fcntl
    import termios

    os.setsid()
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def _told(launched: object, count: int) -> list[dict[str, Any]]:
    import json

    return [json.loads(launched.told.get(timeout=PATIENCE)) for _ in range(count)]  # type: ignore[attr-defined]
