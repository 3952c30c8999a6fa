"""A Zenoh library that knows nothing of ROS.

    protocol    the protocol as pure code: bytes and times go in, bytes and calls come out
    io          sockets for it, and the session that owns them

`goalwire.transport.zenoh` maps ROS 2 onto it, as rmw_zenoh does.
"""
