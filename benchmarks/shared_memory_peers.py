"""Others' ways to send many bytes to another Python process: TCP, eclipse-zenoh's shared memory, iceoryx2.

`benchmarks.shared_memory` runs them beside goalwire. A child process writes the time at which each message
has come into a pipe. A peer that copies hands the child bytes of its own; iceoryx2 lends and shows.
"""

from __future__ import annotations

import ctypes
import os
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from statistics import median
from typing import Any, NamedTuple, Protocol

NAME = 'benchmarks.shared_memory_peers'
POOL = 256 << 20
TIME = struct.Struct('q')
LENGTH = struct.Struct('Q')
ADDRESS = '127.0.0.1'


class Sender(Protocol):
    """The half of a peer that publishes."""

    def prepare(self, payload: bytes) -> None:
        """Do what is not measured, such as a loan."""

    def send(self) -> None:
        """Send what was prepared."""


class TcpSender:
    """Plain Python on TCP: a length, then the bytes."""

    def __init__(self, number: int) -> None:
        self._listener = socket.create_server((ADDRESS, number))
        self._sock: socket.socket | None = None
        self._payload = b''

    def prepare(self, payload: bytes) -> None:
        if self._sock is None:
            self._sock, _ = self._listener.accept()
            self._sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._payload = payload

    def send(self) -> None:
        assert self._sock is not None
        self._sock.sendall(LENGTH.pack(len(self._payload)))
        self._sock.sendall(self._payload)


def receive_tcp(number: int, note: Callable[[], object]) -> None:
    """Read each message into memory of its own."""
    with socket.create_connection((ADDRESS, number)) as sock:
        note()
        while header := sock.recv(LENGTH.size, socket.MSG_WAITALL):
            message = bytearray(LENGTH.unpack(header)[0])
            left = memoryview(message)
            while left and (count := sock.recv_into(left)):
                left = left[count:]
            note()


def _open_zenoh(number: int, role: str) -> Any:
    import zenoh

    config = zenoh.Config()
    endpoint = f'"tcp/{ADDRESS}:{number}"'
    config.insert_json5('scouting/multicast/enabled', 'false')
    config.insert_json5('listen/endpoints', f'[{endpoint}]' if role == 'listen' else '[]')
    config.insert_json5('connect/endpoints', f'[{endpoint}]' if role == 'connect' else '[]')
    config.insert_json5('transport/shared_memory/enabled', 'true')
    return zenoh.open(config)


class ZenohSender:
    """eclipse-zenoh: the payload is copied into its shared memory, and then put."""

    def __init__(self, number: int) -> None:
        from zenoh import shm

        self._session = _open_zenoh(number, 'listen')
        self._publisher = self._session.declare_publisher('pictures')
        self._provider = shm.ShmProvider.default_backend(POOL)
        self._policy = shm.BlockOn(shm.Defragment(shm.GarbageCollect()))
        self._payload = b''

    def prepare(self, payload: bytes) -> None:
        while not self._publisher.matching_status.matching:
            time.sleep(0.05)
        self._payload = payload

    def send(self) -> None:
        buffer = self._provider.alloc(len(self._payload), policy=self._policy)
        buffer[:] = self._payload
        self._publisher.put(buffer)


def receive_zenoh(number: int, note: Callable[[], object]) -> None:
    """Copy each message out of the shared memory, in the callback."""

    def take(sample: Any) -> None:
        bytes(sample.payload)
        note()

    session = _open_zenoh(number, 'connect')
    session.declare_subscriber('pictures', take)
    note()
    sys.stdin.read()
    session.close()


def _open_iceoryx(number: int) -> tuple[Any, Any, Any]:
    iceoryx2 = import_module('iceoryx2')
    node = iceoryx2.NodeBuilder.new().create(iceoryx2.ServiceType.Ipc)
    name = iceoryx2.ServiceName.new(f'benchmark/{number}')
    pictures = node.service_builder(name).publish_subscribe(iceoryx2.Slice[ctypes.c_uint8]).open_or_create()
    return node, pictures, node.service_builder(name).event().open_or_create()


class IceoryxSender:
    """iceoryx2: a loan, which is sent as it is, and an event that wakes the receiver."""

    def __init__(self, number: int) -> None:
        self._node, pictures, events = _open_iceoryx(number)
        self._publisher = (
            pictures.publisher_builder()
            .initial_max_slice_len(64)
            .allocation_strategy(import_module('iceoryx2').AllocationStrategy.PowerOfTwo)
            .create()
        )
        self._notifier = events.notifier_builder().create()
        self._loan: Any = None

    def prepare(self, payload: bytes) -> None:
        self._loan = self._publisher.loan_slice_uninit(len(payload)).assume_init()

    def send(self) -> None:
        self._loan.send()
        self._notifier.notify()


def receive_iceoryx(number: int, note: Callable[[], object]) -> None:
    """Look at each message in shared memory, without a copy."""
    _node, pictures, events = _open_iceoryx(number)
    subscriber = pictures.subscriber_builder().create()
    listener = events.listener_builder().create()
    note()
    while True:
        listener.blocking_wait()
        while (sample := subscriber.receive()) is not None:
            sample.payload().as_memory_view()
            note()
            sample.delete()


class Peer(NamedTuple):
    """Another way to send bytes to a process, and the package that it needs."""

    package: str
    sender: Callable[[int], Sender]
    receive: Callable[[int, Callable[[], object]], None]


PEERS = {
    'Python on TCP': Peer('socket', TcpSender, receive_tcp),
    'eclipse-zenoh, memory': Peer('zenoh', ZenohSender, receive_zenoh),
    'iceoryx2, loan and view': Peer('iceoryx2', IceoryxSender, receive_iceoryx),
}


def installed() -> list[str]:
    """Return the peers whose packages are installed."""
    return [name for name, peer in PEERS.items() if find_spec(peer.package)]


def measure(peer: str, number: int, sizes: dict[int, int]) -> None:
    """Print for each size the median time from `send` to the arrival, in µs; `sizes` has the counts."""
    sender = PEERS[peer].sender(number)
    command = [sys.executable, '-m', NAME, 'receive', peer, str(number)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        child.stdout.read(TIME.size)  # the child is ready
        for size, count in sizes.items():
            payload = bytes(size)
            times = []
            for _ in range(count):
                sender.prepare(payload)
                began = time.perf_counter_ns()
                sender.send()
                times.append((TIME.unpack(child.stdout.read(TIME.size))[0] - began) / 1000)
            print(size, median(times[count // 4 :]), flush=True)
        child.kill()


def receive(peer: str, number: int) -> None:
    """Write the time at which each message has come; the first one tells that the receiver is ready."""
    PEERS[peer].receive(number, lambda: os.write(1, TIME.pack(time.perf_counter_ns())))


if __name__ == '__main__':
    receive(sys.argv[2], int(sys.argv[3]))
