"""A Zenoh library that does not depend on ROS.

    protocol    the protocol without I/O: takes bytes and times, returns bytes and makes calls
    io          the sockets, and the session that owns them

`goalwire.transport.zenoh` maps ROS 2 onto this library, as rmw_zenoh does.
"""
