"""Sessions of goalwire's own: sockets for Zenoh's protocol.

    endpoints   addresses such as tcp/localhost:7447
    socket_link one connection: reads, writes, ends
    dialler     connects, again and again where that is asked for
    session     a session: opens, listens, waits, closes

No thread is needed as long as somebody waits in the session's `wire_poller`, an executor for one; else the
session's one thread does.
"""
