"""Listens on the loopback interface to RTPS, and writes down each goal that is sent, to whatever server.

A second reader of the requests would count as a second server, and then missions send nothing. So this one
reads packets. A goal of Fibonacci in CDR has 4 bytes of encapsulation, 16 of its id, and 4 of its order; no
other request of an action has that size. Cyclone DDS puts 16 bytes of its own before the id. RTPS may repeat
a sample that was lost, so a sample's writer and number are written, too.

`tap_dds.py FILE FIRST LAST`, with the first and the last port whose packets are read: the kernel drops the
others, and stamps these, so that a busy machine neither loses one nor makes it look late.
"""

from __future__ import annotations

import ctypes
import os
import socket
import struct
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
ATTACH_FILTER = 26
STAMP = 35  # SO_TIMESTAMPNS
URGENT = -10


def only_ports(first: int, last: int) -> bytes:
    """Return a program for the kernel that accepts UDP over IPv4 to these ports (struct sock_filter)."""
    load_half, load_byte, is_equal, is_at_least, is_more, end = 0x28, 0x30, 0x15, 0x35, 0x25, 0x06
    program = [
        (load_half, 0, 0, 12),
        (is_equal, 0, 6, 0x0800),
        (load_byte, 0, 0, 23),
        (is_equal, 0, 4, 17),
        (load_half, 0, 0, 36),
        (is_at_least, 0, 2, first),
        (is_more, 1, 0, last),
        (end, 0, 0, 65535),
        (end, 0, 0, 0),
    ]
    return b''.join(struct.pack('HBBI', *each) for each in program)


def attach(tap: socket.socket, program: bytes) -> None:
    """Have the kernel drop the packets that the program does not accept."""
    kept = ctypes.create_string_buffer(program, len(program))
    tap.setsockopt(
        socket.SOL_SOCKET, ATTACH_FILTER, struct.pack('HP', len(program) // 8, ctypes.addressof(kept))
    )


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


def main(path: str, first: str, last: str) -> None:
    os.setpriority(os.PRIO_PROCESS, 0, URGENT)
    since_boot = time.monotonic() - time.time()
    with (
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ALL_PROTOCOLS)) as tap,
        Path(path).open('a', encoding='utf-8') as heard,
    ):
        tap.setsockopt(socket.SOL_SOCKET, RECEIVE_BUFFER_FORCE, BUFFER)
        tap.setsockopt(socket.SOL_SOCKET, STAMP, 1)
        attach(tap, only_ports(int(first), int(last)))
        tap.bind(('lo', ALL_PROTOCOLS))
        print('ready', flush=True)
        while True:
            data, [(_, _, stamp)], _, _ = tap.recvmsg(65535, 64)
            packet = data[BEFORE_RTPS:]
            if packet.startswith(b'RTPS'):
                try:
                    found = list(goals(packet))
                except RtpsError:
                    continue
                seconds, nanoseconds = struct.unpack('ll', stamp)
                for goal_id, sample in found:
                    at = since_boot + seconds + nanoseconds / 1e9
                    print(goal_id, sample, at, file=heard, flush=True)


main(*sys.argv[1:])
