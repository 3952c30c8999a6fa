"""The messages of a link itself, as bytes: INIT and OPEN set it up, CLOSE ends it, KEEP_ALIVE keeps it.

This module has only the numbers of FRAME and FRAGMENT; `frames` decodes them.

A link carries batches: two bytes of length, low byte first, then that many bytes. A batch holds one or more
of these messages. A FRAME's network messages go on until the batch ends, or until a byte comes whose five low
bits are below FIRST_NETWORK_ID: there the next message of the link begins.
"""

from __future__ import annotations

from enum import IntEnum

from goalwire.records import record
from goalwire.zenoh.protocol.primitives import (
    MORE,
    UNSUPPORTED,
    VERSION,
    Reader,
    ZenohProtocolError,
    encode_data,
    encode_z,
)
from goalwire.zenoh.protocol.shared_memory import DATA_IN_OPEN, EXTENSION_OF_INIT, NUMBER_IN_OPEN

INIT, OPEN, CLOSE, KEEP_ALIVE, FRAME, FRAGMENT = range(1, 7)
FIRST_NETWORK_ID = 0x19
MESSAGE_ID = 0x1F
"""The bits of a message's first byte that identify its kind; the other three bits are flags."""

IS_ANSWER = 0x20
HAS_SIZES = 0x40
IN_SECONDS = 0x40

NUMBER_BITS = (7, 14, 28)
"""Bits of a sequence number if INIT asks for 8, 16 or 32: Zenoh's encoding uses one bit of each byte."""
LARGEST_NUMBERS = 2
"""The code in INIT for numbers of 32 bits. 3 stands for 64 bits, which goalwire does not support."""
SIZES = 0x0A
"""Sequence numbers and request ids of 32 bits: the sizes that apply if INIT names none."""
MAX_BATCH = 65535
MAX_COOKIE = 65535

QOS = 0x01
"""The extension of INIT that offers eight priorities instead of one."""
PATCH = 0x27
"""The extension of INIT that offers a patch of the protocol: 1 marks the first piece of a message."""
OUR_PATCH = 1


class Role(IntEnum):
    """The role of a session, as INIT numbers it."""

    ROUTER = 0
    PEER = 1
    CLIENT = 2


@record
class Init:
    """The identity and abilities of one side; only an answer has a `cookie`."""

    zid: bytes
    role: Role
    batch_size: int = MAX_BATCH
    qos: bool = True
    patch: int = OUR_PATCH
    cookie: bytes | None = None
    number_size: int = LARGEST_NUMBERS
    """The size of sequence numbers, as an index into NUMBER_BITS."""
    memory: bytes | None = None
    """The offer of shared memory, or the answer to it; None if the link is to carry bytes only."""

    @property
    def number_mask(self) -> int:
        """The mask with all bits of a sequence number set."""
        return (1 << NUMBER_BITS[self.number_size]) - 1

    def encode(self) -> bytes:
        """Return the message."""
        header = INIT | HAS_SIZES | (0 if self.cookie is None else IS_ANSWER)
        extensions = [bytes((QOS,))] * self.qos
        if self.memory is not None:
            extensions.append(bytes((EXTENSION_OF_INIT,)) + encode_data(self.memory))
        if self.patch:
            extensions.append(bytes((PATCH,)) + encode_z(self.patch))
        return b''.join(
            (
                bytes((header | (MORE if extensions else 0), VERSION, (len(self.zid) - 1) << 4 | self.role)),
                self.zid,
                bytes((LARGEST_NUMBERS << 2 | self.number_size,)),
                self.batch_size.to_bytes(2, 'little'),
                b'' if self.cookie is None else encode_data(self.cookie),
                chain(extensions),
            )
        )

    @classmethod
    def decode(cls, reader: Reader) -> Init:
        """Read an INIT. Raises ZenohProtocolError, also for another version or smaller request ids."""
        header = reader.u8()
        version = reader.u8()
        if version != VERSION:
            raise ZenohProtocolError(
                f'it speaks version {version} of the protocol, not {VERSION}', UNSUPPORTED
            )
        who = reader.u8()
        if who & 3 == 3:
            raise ZenohProtocolError('it sent 3 as its role, and no role has that number', UNSUPPORTED)
        zid = reader.zid((who >> 4) + 1)
        sizes, batch_size = SIZES, MAX_BATCH
        if header & HAS_SIZES:
            sizes = reader.u8()
            batch_size = int.from_bytes(reader.take(2), 'little')
        if sizes >> 2 & 3 < LARGEST_NUMBERS:
            raise ZenohProtocolError(f'it wants request ids of another size (0x{sizes:02x})', UNSUPPORTED)
        cookie = None
        if header & IS_ANSWER:
            cookie = reader.take_sized()
            if len(cookie) > MAX_COOKIE:
                raise ZenohProtocolError(f'a cookie of {len(cookie)} bytes')
        found = reader.extensions({QOS, PATCH, EXTENSION_OF_INIT}) if header & MORE else {}
        patch = found.get(PATCH, 0)
        memory = found.get(EXTENSION_OF_INIT)
        assert isinstance(patch, int)
        assert not isinstance(memory, int)
        return cls(zid, Role(who & 3), batch_size, QOS in found, patch, cookie, sizes & 3, memory)


@record
class Open:
    """The lease in ms and the first sequence number of one side. An answer has no cookie."""

    lease_ms: int
    first_number: int
    cookie: bytes | None = None
    memory: int | bytes | None = None
    """The proof that the other side's segment was read, or the acceptance of it; a number until Zenoh 1.9."""

    def encode(self) -> bytes:
        """Return the message; whole seconds are sent as seconds."""
        seconds, rest = divmod(self.lease_ms, 1000)
        header = OPEN | (IS_ANSWER if self.cookie is None else 0) | (0 if rest else IN_SECONDS)
        extension = b''
        if self.memory is not None:
            header |= MORE
            extension = _memory_in_open(self.memory)
        lease = encode_z(self.lease_ms if rest else seconds)
        cookie = b'' if self.cookie is None else encode_data(self.cookie)
        return bytes((header,)) + lease + encode_z(self.first_number) + cookie + extension

    @classmethod
    def decode(cls, reader: Reader) -> Open:
        """Read an OPEN. Raises ZenohProtocolError."""
        header = reader.u8()
        lease = reader.z() * (1000 if header & IN_SECONDS else 1)
        first_number = reader.z()
        if first_number >> 28:
            raise ZenohProtocolError(f'first sequence number {first_number} has more than 28 bits')
        cookie = None if header & IS_ANSWER else reader.take_sized()
        found = reader.extensions({NUMBER_IN_OPEN, DATA_IN_OPEN}) if header & MORE else {}
        return cls(lease, first_number, cookie, found.get(DATA_IN_OPEN, found.get(NUMBER_IN_OPEN)))


def _memory_in_open(value: int | bytes) -> bytes:
    if isinstance(value, int):
        return bytes((NUMBER_IN_OPEN,)) + encode_z(value)
    return bytes((DATA_IN_OPEN,)) + encode_data(value)


def chain(extensions: list[bytes]) -> bytes:
    """Join extensions to a list: each but the last gets the flag that another follows."""
    return b''.join(
        bytes((each[0] | MORE,)) + each[1:] if more else each
        for more, each in zip(range(len(extensions) - 1, -1, -1), extensions, strict=True)
    )


def close_message(reason: int) -> bytes:
    """Return CLOSE for this link only."""
    return bytes((CLOSE, reason))


KEEP_ALIVE_MESSAGE = bytes((KEEP_ALIVE,))
