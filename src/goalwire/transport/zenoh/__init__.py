"""ROS 2 over Zenoh, byte for byte as rmw_zenoh_cpp speaks it; zenoh is imported at the first open."""

from __future__ import annotations

from goalwire.transport.contract import Session, SessionOptions, Transport


class ZenohTransport(Transport):
    """The wire of rmw_zenoh_cpp."""

    identifier = 'rmw_zenoh_cpp'

    def open(self, options: SessionOptions) -> Session:
        """Connect as the environment says. Raises TransportError or ForkedError."""
        from goalwire.transport.zenoh.session import open_session

        return open_session(options)


TRANSPORT = ZenohTransport()

__all__ = ['TRANSPORT', 'ZenohTransport']
