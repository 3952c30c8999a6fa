"""Links that come and go: what a process holds whose peers die, close, or are refused in the handshake."""

from __future__ import annotations

import gc
import os
import signal
import socket
import sys
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep

from benchmarks import spinning, stage
from benchmarks.endurance.held import Held
from benchmarks.line import Figures
from goalwire.transport.contract import NodeName
from goalwire.transport.zenoh.ros_keys import encode_node
from goalwire.zenoh.io.native_session import NativeSession
from goalwire.zenoh.io.settings import Settings

SESSIONS = 20
"""So many links at a time: those of one process."""
VERSION_8 = bytes.fromhex('0d00c10831b1b2b3b40ac8ff812701')
_LISTENS = '0A'


def answer(port: int = 0) -> None:
    if port:
        come_and_go(port)
        return
    import rclpy

    rclpy.init()
    node = rclpy.create_node('endurance_stays')
    stage.obey({'nodes': lambda: len(node.get_node_names()), 'collect': gc.collect})
    rclpy.shutdown()


def come_and_go(port: int) -> None:
    """Open sessions that connect to one port, each with a node to be seen by."""
    domain = int(os.environ['ROS_DOMAIN_ID'])
    settings = Settings(listen=(), connect=(f'tcp/127.0.0.1:{port}',), meets_peers=False)
    sessions = [NativeSession(settings) for _ in range(SESSIONS)]
    for number, session in enumerate(sessions):
        session.protocol.declare_token(encode_node(domain, session.id, 0, NodeName(f'endurance_{number}')))

    def close() -> None:
        for session in sessions:
            session.close()

    stage.obey({'die': lambda: os.kill(os.getpid(), signal.SIGKILL), 'close': close})


def ask(count: int) -> Figures:
    with stage.Partner('benchmarks.endurance.links') as stays:
        _meet(stays, 'die')
        _meet(stays, 'close')
        _be_refused(stays.pid)
        stays.do('collect')
        held = Held(process=stays.pid)
        rounds = max(count // (3 * SESSIONS), 1)
        watch = stage.Stopwatch()
        for _ in range(rounds):
            _meet(stays, 'die')
            _meet(stays, 'close')
            for _ in range(SESSIONS):
                _be_refused(stays.pid)
        seconds = watch.read()
        stays.do('collect')
        return held.since() | {'links': float(3 * SESSIONS * rounds), 's': seconds}


def _meet(stays: stage.Partner, end: str) -> None:
    """Have sessions meet the one that stays, and end."""
    with stage.Partner('benchmarks.endurance.links', _port_of(stays.pid)) as goes:
        _wait_for_nodes(stays, 1 + SESSIONS)
        goes.order(end)
        _wait_for_nodes(stays, 1)
        if end == 'close':
            goes.result()


def _wait_for_nodes(stays: stage.Partner, number: int) -> None:
    deadline = monotonic() + 3 * spinning.PATIENCE_S
    while (found := stays.do('nodes')) != number:
        if monotonic() > deadline:
            sys.exit(f'{found:g} nodes are seen, not {number}')
        sleep(0.01)


def _be_refused(pid: int) -> None:
    """Begin a handshake in a version that nobody speaks."""
    with socket.create_connection(('127.0.0.1', _port_of(pid)), timeout=spinning.PATIENCE_S) as stranger:
        stranger.sendall(VERSION_8)
        while stranger.recv(4096):
            pass


def _port_of(pid: int) -> int:
    """Return the port of 127.0.0.1 where a process listens."""
    sockets = set()
    for descriptor in Path(f'/proc/{pid}/fd').iterdir():
        with suppress(FileNotFoundError):  # closed meanwhile
            sockets.add(str(descriptor.readlink()))
    for line in Path('/proc/net/tcp').read_text().splitlines()[1:]:
        fields = line.split()
        if fields[3] == _LISTENS and f'socket:[{fields[9]}]' in sockets:
            return int(fields[1].rpartition(':')[2], 16)
    sys.exit('the session listens nowhere')


if __name__ == '__main__':
    stage.run(ask, answer)
