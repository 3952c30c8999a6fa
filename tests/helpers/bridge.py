"""A bridge as a process, and clients that speak its protocol word by word."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

from helpers.patience import PATIENCE
from helpers.processes import Program
from websockets.sync.client import ClientConnection, connect


class Bridge(NamedTuple):
    """A bridge that takes clients."""

    program: Program
    url: str


def start_bridge(stack: ExitStack, env: Mapping[str, str], protocol: str, *options: str) -> Bridge:
    """Start one at a free port; it ends with the stack."""
    program = stack.enter_context(
        Program(Path('-m'), 'goalwire', 'bridge', protocol, '--port', '0', '--json', *options, env=env)
    )
    return Bridge(program, json.loads(program.expect('{"url":').string)['url'])


class WebSocket:
    """A client of rosbridge that hides nothing: `send` an operation, wait for one with `expect`."""

    def __init__(self, url: str, **options: Any) -> None:
        self._connect = connect(url, max_size=None, **options)
        self.socket: ClientConnection

    def send(self, op: str, /, **fields: Any) -> None:
        """Send an operation in JSON."""
        self.socket.send(json.dumps({'op': op, **fields}))

    def receive(self) -> Any:
        """Return the next operation; CBOR as bytes."""
        frame = self.socket.recv(timeout=PATIENCE)
        return json.loads(frame) if isinstance(frame, str) else frame

    def expect(self, op: str, fits: Callable[[Any], bool] = lambda _: True) -> Any:
        """Return the next operation of that name that fits; others are passed over."""
        while True:
            found = self.receive()
            if found['op'] == op and fits(found):
                return found

    def call(self, service: str, /, **args: Any) -> Any:
        """Call a service; return the whole answer."""
        self.send('call_service', id=service, service=service, args=args)
        return self.expect('service_response')

    def __enter__(self) -> Self:
        self.socket = self._connect.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connect.__exit__(kind, error, trace)
