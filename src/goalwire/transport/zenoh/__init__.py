"""ROS 2 over Zenoh, byte for byte as rmw_zenoh_cpp speaks it; zenoh is imported at the first open."""

from __future__ import annotations

from goalwire.transport.contract import Session, SessionOptions, Transport


def _open(options: SessionOptions) -> Session:
    """Open a session as the environment's variables say. Raises TransportError or ForkedError."""
    from goalwire.transport.zenoh.session import open_session

    return open_session(options)


TRANSPORT = Transport('rmw_zenoh_cpp', _open)

__all__ = ['TRANSPORT']
