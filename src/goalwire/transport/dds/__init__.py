"""ROS 2 over DDS, as rmw_cyclonedds_cpp speaks it; the library is loaded at the first open."""

from __future__ import annotations

from goalwire.transport.contract import Session, SessionOptions, Transport


def _open(options: SessionOptions) -> Session:
    """Join a domain as the environment says. Raises TransportError or ForkedError."""
    from goalwire.transport.dds.cyclone.session import open_session

    return open_session(options)


TRANSPORT = Transport('rmw_cyclonedds_cpp', _open)

__all__ = ['TRANSPORT']
