"""Faults on any wire: delay, loss, duplication, reordering, partitions, slow readers, deaths, flipped bytes.

`Faults` holds the faults of the moment, and can be changed while programs run. `faults.over(transport)` wraps
a transport; `with faults:` wraps whatever this process opens.
"""

from goalwire.transport.faults.kinds import (
    Delay,
    Duplication,
    FailedCall,
    Fault,
    FlippedBytes,
    Kill,
    Kind,
    Loss,
    LostReply,
    Packet,
    Partition,
    Point,
    Reordering,
    SlowReader,
)
from goalwire.transport.faults.session import Faults

__all__ = [
    'Delay',
    'Duplication',
    'FailedCall',
    'Fault',
    'Faults',
    'FlippedBytes',
    'Kill',
    'Kind',
    'Loss',
    'LostReply',
    'Packet',
    'Partition',
    'Point',
    'Reordering',
    'SlowReader',
]
