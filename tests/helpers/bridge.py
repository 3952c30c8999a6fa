"""A bridge as a process, and clients that speak its protocol word by word."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from types import TracebackType
from typing import Any, NamedTuple, Self

from helpers.command_line import executable
from helpers.patience import PATIENCE
from helpers.processes import Program
from helpers.programs import server_of_programs
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol


class Bridge(NamedTuple):
    """A bridge that takes clients."""

    program: Program
    url: str


def start_bridge(stack: ExitStack, env: Mapping[str, str], protocol: str, *options: str) -> Bridge:
    """Start one at a free port; it ends with the stack."""
    words = 'bridge', protocol, '--port', '0', '--json'
    program = stack.enter_context(
        Program(executable('goalwire'), *words, *options, env=env, server=server_of_programs())
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


class FoxgloveClient:
    """A client of Foxglove's protocol; it begins when it has seen the robot's service `/add`."""

    def __init__(self, url: str, **options: Any) -> None:
        self._connect = connect(
            url, max_size=None, subprotocols=[Subprotocol('foxglove.websocket.v1')], **options
        )
        self.socket: ClientConnection
        self.channels: dict[str, Any] = {}
        self.services: dict[str, Any] = {}
        self.greeting: dict[str, Any] = {}
        """The serverInfo."""
        self.feedback: list[bytes] = []
        """Messages that came while something else was waited for."""
        self._calls = 0

    def send(self, op: str, /, **fields: Any) -> None:
        """Send an operation."""
        self.socket.send(json.dumps({'op': op, **fields}))

    def _receive(self) -> Any:
        frame = self.socket.recv(timeout=PATIENCE)
        if isinstance(frame, bytes):
            return frame
        found = json.loads(frame)
        if found['op'] == 'serverInfo':
            self.greeting = found
        for each in found.get('channels', ()):
            self.channels[each['topic']] = each
        for each in found.get('services', ()):
            self.services[each['name']] = each
        return found

    def expect(self, op: str) -> Any:
        """Return the next operation of that name."""
        while True:
            found = self._receive()
            if not isinstance(found, bytes) and found['op'] == op:
                return found

    def receive_bytes(self) -> bytes:
        """Return the next binary frame."""
        while not isinstance(found := self._receive(), bytes):
            pass
        return found

    def channel(self, topic: str) -> Any:
        """Return the channel of a topic, when it is shown."""
        while topic not in self.channels:
            self._receive()
        return self.channels[topic]

    def subscribe(self, topic: str, number: int) -> None:
        """Subscribe to a topic."""
        channel = self.channel(topic)['id']
        self.send('subscribe', subscriptions=[{'id': number, 'channelId': channel}])

    def ask(self, service: str, request: bytes) -> int:
        """Begin to call a service; return the number of the call."""
        while service not in self.services:
            self._receive()
        self._calls += 1
        number = self.services[service]['id']
        self.socket.send(struct.pack('<BIII', 2, number, self._calls, 3) + b'cdr' + request)
        return self._calls

    def call(self, service: str, request: bytes) -> bytes:
        """Call a service; return the response."""
        call = self.ask(service, request)
        while True:
            frame = self.receive_bytes()
            if frame[0] == 1:
                self.feedback.append(frame[13:])
            elif frame[0] == 3 and struct.unpack_from('<I', frame, 5)[0] == call:
                return frame[16:]

    def call_fails(self, service: str, request: bytes) -> str:
        """Call a service; return why it fails."""
        self.ask(service, request)
        text: str = self.expect('serviceCallFailure')['message']
        return text

    def __enter__(self) -> Self:
        self.socket = self._connect.__enter__()
        try:
            while '/add' not in self.services and '/robot_description' not in self.channels:
                self._receive()
        except BaseException:
            self.socket.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connect.__exit__(kind, error, trace)
