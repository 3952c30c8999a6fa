"""Listens on the loopback interface to RTPS, and writes down each goal that is sent, to whatever server.

A second reader of the requests would count as a second server, and then missions send nothing. So this one
reads packets. A goal of Fibonacci in CDR has 4 bytes of encapsulation, 16 of its id, and 4 of its order; no
other request of an action has that size. Cyclone DDS puts 16 bytes of its own before the id. RTPS may repeat
a sample that was lost, so a sample's writer and number are written, too.
"""

from __future__ import annotations

import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from goalwire.rtps.protocol.messages import Data, read_body, split
from goalwire.rtps.protocol.parameters import read_related_sample
from goalwire.rtps.protocol.primitives import RtpsError

ALL_PROTOCOLS = 3
BEFORE_RTPS = 14 + 20 + 8  # the headers of Ethernet, IPv4 and UDP
PREFIX = slice(8, 20)
GOAL_ID = slice(-20, -4)
SIZE = 24
SIZE_WITH_HEADER = 40
RECEIVE_BUFFER_FORCE = 33
BUFFER = 1 << 25


def is_goal(data: Data) -> bool:
    """Return whether a sample may be a goal."""
    size = len(data.payload or b'')
    if not data.qos:
        return size == SIZE_WITH_HEADER
    return size == SIZE and read_related_sample(data.qos) is not None


def goals(packet: bytes) -> Iterator[tuple[str, str]]:
    """Yield the id of each goal in an RTPS packet, and the id of its sample."""
    for kind, flags, at, end in split(packet):
        body = read_body(kind, packet, at, end, flags)
        if isinstance(body, Data) and is_goal(body):
            assert body.payload is not None
            yield body.payload[GOAL_ID].hex(), f'{packet[PREFIX].hex()}{body.writer.hex()}-{body.number}'


def main(path: str) -> None:
    with (
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ALL_PROTOCOLS)) as tap,
        Path(path).open('a', encoding='utf-8') as heard,
    ):
        tap.setsockopt(socket.SOL_SOCKET, RECEIVE_BUFFER_FORCE, BUFFER)
        tap.bind(('lo', ALL_PROTOCOLS))
        print('ready', flush=True)
        while True:
            packet = tap.recv(65535)[BEFORE_RTPS:]
            if packet.startswith(b'RTPS'):
                try:
                    found = list(goals(packet))
                except RtpsError:
                    continue
                for goal_id, sample in found:
                    print(goal_id, sample, time.monotonic(), file=heard, flush=True)


main(sys.argv[1])
