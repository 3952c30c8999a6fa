"""Sockets for Zenoh's protocol, and the session that owns them.

    settings        what a session is opened with
    endpoints       addresses such as tcp/localhost:7447
    socket_link     one connection: reads, writes, ends
    identities      the identity of a link's other side, by its certificate
    tls             one connection with TLS on it
    link_maker      makes the link of a connection, plain or with TLS
    listeners       sockets that accept the connections of others
    dialler         connects to one node, and tries again after a failure if that is asked for
    dials           all addresses and nodes that a session connects to
    flusher         sends the small messages that links hold back for a moment to share a frame
    backpressure    threads that wait until a link has room
    query_timer     ends the queries that have timed out
    suspension      restores the links after the process was suspended for a while
    fault_log       log lines about peers that broke the protocol
    native_session  the session: opens its links, carries out the protocol's requests, and closes

A thread that waits in the session's `wire_poller`, for example an executor, also reads the sockets. While
there is none, a thread of the session's own reads them.
"""
