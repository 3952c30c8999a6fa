"""The transport within one process: every context of a domain meets on a bus, no wire involved."""

from goalwire.transport.memory.session import MemoryTransport

TRANSPORT = MemoryTransport()

__all__ = ['TRANSPORT', 'MemoryTransport']
