"""The layout of the segments, byte for byte: equal in Zenoh 1.2.3 to 1.10, except the handshake's segment.

All numbers are in the machine's own byte order, and each is aligned.

The handshake's segment until Zenoh 1.9: three numbers of 64 bits (how many protocols, the inverted challenge,
version 1), and the protocols, of 64 bits. Since 1.10: the same three (the challenge as it is, version 2), 256
protocols of 32 bits, and counters that senders lend to readers. A segment in the newer form serves both: from
the returned challenge its owner learns which form the reader knows.
"""

from __future__ import annotations

from struct import Struct

WORD = (1 << 64) - 1

# ---- the handshake's segment

AUTH_HEAD = Struct('=QQQ')
"""The segment's first fields: the number of protocols, the challenge, the version."""
AUTH_SIZE = 12_288
OLD_VERSION, VERSION = 1, 2
PROTOCOLS_AT = 24
MOST_PROTOCOLS = 256
POSIX = 0
"""The number by which Zenoh names the protocol of segments in /dev/shm."""
MARK_AT = PROTOCOLS_AT + 4 * 252
"""The offset of goalwire's mark, in unused entries of the table of protocols."""
MARK = Struct('=QII')
MAGIC = 0x67_6F_61_6C_77_69_72_65
"""Marks a segment of goalwire's: the bytes of 'goalwire'."""
READS_OWN_HEADERS = 1
"""A flag in the mark: the owner can read goalwire's pointers, whose headers each serve one reader only."""
COUNTERS_AT = 1048
COUNTERS = 2810

# ---- the metadata segment

HEADER = Struct('=IB3xIIIIQ')
"""The fields of a header: count, invalidated, generation, protocol, data segment, offset, length."""
HEADERS = 32_768
WATCHDOGS_AT = HEADERS * HEADER.size
METADATA_SIZE = WATCHDOGS_AT + HEADERS * 8
OWNER_AT = METADATA_SIZE - 16
"""The offset of goalwire's mark, which names the segment's owner, in unused words of the watchdogs."""
OWNER = Struct('=QQ')
"""The fields of the owner's mark: MAGIC, and the number of the owner's segment for the handshake."""

MOST_CHUNK = 1 << 32
"""The largest size of a data segment, in bytes: offsets have 32 bits."""
