"""Runs a program with a mistake, as a process of its own, until its end; watches what it says, and when."""

from __future__ import annotations

import os
import re
import select
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from helpers.forking import Forked, ForkServer

from goalwire.records import record

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mistakes.catalog import Mistake

_END_S = 30.0
"""How long a program may take in all; only a failure takes that long."""


@record
class Told:
    """The output of a program, and the seconds until it had said what is expected (None: never)."""

    output: str
    after: float | None


PRELOADED = (
    'example_interfaces.action', 'rclpy', 'rclpy.action', 'rclpy.executors', 'rclpy.node', 'rclpy.parameter',
    'sensor_msgs.msg', 'std_msgs.msg', 'std_srvs.srv',
)  # fmt: skip
"""The modules that the programs import."""


def run(mistake: Mistake, folder: Path, environment: Mapping[str, str], server: ForkServer) -> Told:
    """Run a program in a copy of its folder, below `folder`."""
    place = folder / 'program'
    alone = mistake.file.name in {'program.py', 'command.sh'}
    if alone:
        shutil.copytree(mistake.file.parent, place)
    else:
        place.mkdir(parents=True)
        shutil.copy(mistake.file, place)
    environment = {**environment, 'PATH': f'{Path(sys.executable).parent}:{environment["PATH"]}'}
    (keyboard, typing), (output, said) = os.pipe(), os.pipe()
    began = monotonic()
    process: subprocess.Popen[bytes] | Forked
    try:
        if alone:
            runner = 'bash' if mistake.file.suffix == '.sh' else sys.executable
            process = subprocess.Popen(
                [runner, mistake.file.name, *mistake.arguments],
                cwd=place, env=environment, stdin=keyboard, stdout=said, stderr=said, start_new_session=True,
            )  # fmt: skip
        else:
            process = server.start(
                Path(mistake.file.name),
                mistake.arguments,
                environment=environment,
                folder=place,
                streams=(keyboard, said, said),
            )
    finally:
        os.close(keyboard)
        os.close(said)
    try:
        return _watch(mistake, place, output, process.pid, began)
    finally:
        os.close(output)
        os.close(typing)
        process.wait()


def _watch(mistake: Mistake, folder: Path, output: int, pid: int, began: float) -> Told:
    """Read until the end; Ctrl-C ends a program that goes on, once it has told."""
    text, after, interrupt_at = '', None, None
    wanted = _flat(mistake.says)
    if mistake.ctrl_c.startswith('at '):
        interrupt_at = began + float(mistake.ctrl_c.removeprefix('at ').removesuffix(' s'))
    while True:
        now = monotonic()
        if now > began + _END_S:
            with suppress(ProcessLookupError):
                os.killpg(pid, signal.SIGKILL)
            return Told(f'{text}\n(killed after {_END_S} s)', after)
        if interrupt_at is not None and now >= interrupt_at:
            interrupt_at = None
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGINT)
        wait = (began + _END_S if interrupt_at is None else interrupt_at) - now
        if not select.select([output], [], [], max(wait, 0.0))[0]:
            continue
        data = os.read(output, 1 << 16)
        if not data:
            return Told(text, after)
        text = (text + data.decode(errors='replace')).replace(f'{folder}{os.sep}', '')
        if after is None and wanted in _flat(text):
            after = monotonic() - began
            if mistake.ctrl_c:
                interrupt_at = monotonic()


def _flat(text: str) -> str:
    return re.sub(r'\s+', ' ', text)


def count(says: str, output: str) -> int:
    """Return how often a sentence stands in an output, wherever its lines are broken."""
    return _flat(output).count(_flat(says))
