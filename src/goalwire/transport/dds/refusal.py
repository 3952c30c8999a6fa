"""What goalwire's servers send where they will not answer: a reply that stock ROS 2 takes for nobody's.

rmw_cyclonedds' services have no such thing. So it goes to clients alone that say in their USER_DATA that they
know it (`goalwire=1`; other readers of USER_DATA skip unknown keys). Every client of the service receives it,
as all replies; those of stock ROS 2 drop it, for it bears another client's id. Its sequence number is the
request's, negative. They decode it first: zeros, which are a value of every type, and then the reason.
"""

from __future__ import annotations

from struct import Struct

from goalwire.errors import peer_text
from goalwire.transport.dds.service_header import ENCAPSULATION_SIZE, Header, wrap

_ZEROS = bytes(1024)
_ENCAPSULATION = b'\0\1\0\0'
_SIZE = Struct('<I')
_LONGEST = 1000


def refusal(header: Header, reason: str) -> bytes:
    """Return the whole reply that refuses a request: zeros, the reason, and how long that is."""
    text = reason.encode()[:_LONGEST]
    padded = text.ljust(-(-len(text) // 4) * 4, b'\0')
    message = b''.join((_ENCAPSULATION, _ZEROS, padded, _SIZE.pack(len(text))))
    return wrap(Header(header.client, -header.sequence), message)


def refusal_reason(message: bytes) -> str:
    """Return the reason in a refusal without its header; what cannot be read counts as none."""
    end = len(message) - _SIZE.size
    if end < ENCAPSULATION_SIZE:
        return ''
    (size,) = _SIZE.unpack_from(message, end)
    start = end - -(-size // 4) * 4
    return (
        peer_text(message[start : start + size].decode(errors='replace'), _LONGEST)
        if start >= ENCAPSULATION_SIZE
        else ''
    )
