"""Notebooks: cells that a real Jupyter kernel runs, in a process of its own."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Any, Self

from helpers.patience import NOTEBOOK
from jupyter_client.manager import KernelManager


@contextmanager
def _standing_kernel(cwd: Path, env: Mapping[str, str]) -> Iterator[KernelManager]:
    """Start a kernel, and end it after the block.

    Its sockets are files: Jupyter chooses TCP ports some time before the kernel takes them, and other
    programs of the machine may have taken one by then.
    """
    with TemporaryDirectory() as folder:  # with a short path: a socket's path has about a hundred characters
        manager = KernelManager(
            kernel_name='python3', transport='ipc', connection_file=f'{folder}/kernel.json'
        )
        manager.start_kernel(cwd=str(cwd), env=dict(env))
        try:
            yield manager
        finally:
            manager.shutdown_kernel(now=True)
            manager.cleanup_resources()


class Notebook:
    """A kernel. A cell's output has what it printed, its value, and its error as `Name: text`.

    A cell's text on stderr follows all of that: the kernel may send it in the midst of a line of stdout.
    """

    def __init__(self, cwd: Path, env: Mapping[str, str]) -> None:
        with ExitStack() as undo:
            self._manager = undo.enter_context(_standing_kernel(cwd, env))
            provisioner: Any = self._manager.provisioner
            self._pid: int = provisioner.pid
            self._client = self._manager.blocking_client()
            undo.callback(self._client.stop_channels)
            self._client.start_channels()
            self._client.wait_for_ready(timeout=NOTEBOOK)
            self._ending = undo.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ending.close()

    def run(self, cell: str, *, interrupted_after: str | None = None) -> str:
        """Run a cell and return its output; Interrupt is pressed once it has printed that line."""
        output: list[str] = []
        complaints: list[str] = []
        interrupted = False

        def take(message: dict[str, Any]) -> None:
            nonlocal interrupted
            content = message['content']
            match message['msg_type']:
                case 'stream' if content['name'] == 'stderr':
                    complaints.append(content['text'])
                case 'stream':
                    output.append(content['text'])
                    # The kernel may send a line and its end apart; Interrupt between them would lose the end.
                    line = f'{interrupted_after}\n'
                    if interrupted_after is not None and not interrupted and line in ''.join(output):
                        interrupted = True
                        os.kill(self._pid, signal.SIGINT)  # what the button does
                case 'execute_result':
                    output.append(content['data']['text/plain'] + '\n')
                case 'error':
                    output.append(f'{content["ename"]}: {content["evalue"]}\n')

        self._client.execute_interactive(cell, output_hook=take, timeout=NOTEBOOK)
        return ''.join([*output, *complaints])
