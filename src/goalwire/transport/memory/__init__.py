"""The transport within one process: every context of a domain meets there, and no wire is involved."""

from goalwire.transport.memory.session import TRANSPORT

__all__ = ['TRANSPORT']
