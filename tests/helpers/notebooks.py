"""Notebooks: cells that a real Jupyter kernel runs, in a process of its own."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from helpers.patience import NOTEBOOK
from jupyter_client.manager import KernelManager


class Notebook:
    """A kernel. A cell's output has what it printed, its value, and its error as `Name: text`."""

    def __init__(self, cwd: Path, env: Mapping[str, str]) -> None:
        self._manager = KernelManager(kernel_name='python3')
        self._manager.start_kernel(cwd=str(cwd), env=dict(env))
        provisioner: Any = self._manager.provisioner
        self._pid: int = provisioner.pid
        self._client = self._manager.blocking_client()
        self._client.start_channels()
        self._client.wait_for_ready(timeout=NOTEBOOK)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.stop_channels()
        self._manager.shutdown_kernel(now=True)
        self._manager.cleanup_resources()

    def run(self, cell: str, *, interrupted_after: str | None = None) -> str:
        """Run a cell and return its output; Interrupt is pressed once it has printed the text given."""
        output: list[str] = []

        def take(message: dict[str, Any]) -> None:
            content = message['content']
            match message['msg_type']:
                case 'stream':
                    output.append(content['text'])
                    if interrupted_after is not None and interrupted_after in content['text']:
                        os.kill(self._pid, signal.SIGINT)  # what the button does
                case 'execute_result':
                    output.append(content['data']['text/plain'] + '\n')
                case 'error':
                    output.append(f'{content["ename"]}: {content["evalue"]}\n')

        self._client.execute_interactive(cell, output_hook=take, timeout=NOTEBOOK)
        return ''.join(output)
