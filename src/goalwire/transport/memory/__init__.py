"""The transport within one process: contexts in the same domain meet in memory, without any network."""

from goalwire.transport.memory.session import MemoryTransport

TRANSPORT = MemoryTransport()

__all__ = ['TRANSPORT', 'MemoryTransport']
