"""Faults on any wire: delay, loss, duplication, reordering, partitions, slow readers, deaths, flipped bytes.

`Faults` holds what is wrong at the moment and can be changed while everything runs. A transport is wrapped by
`faults.over(transport)`; `with faults:` wraps whatever this process opens.
"""

from goalwire.transport.faults.delay import Delay
from goalwire.transport.faults.duplication import Duplication
from goalwire.transport.faults.failed_call import FailedCall
from goalwire.transport.faults.fault import Fault
from goalwire.transport.faults.flipped_bytes import FlippedBytes
from goalwire.transport.faults.kill import Kill, Point
from goalwire.transport.faults.loss import Loss
from goalwire.transport.faults.lost_reply import LostReply
from goalwire.transport.faults.packet import Kind, Packet
from goalwire.transport.faults.partition import Partition
from goalwire.transport.faults.plan import Faults
from goalwire.transport.faults.reordering import Reordering
from goalwire.transport.faults.slow_reader import SlowReader

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
