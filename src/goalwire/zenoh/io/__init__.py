"""Sockets for Zenoh's protocol, and the session that has them.

    settings        what a session is opened with
    endpoints       addresses such as tcp/localhost:7447
    socket_link     one connection: reads, writes, ends
    identities      who is at the other side of a link, by its certificate
    tls             the same with TLS on it
    link_maker      gives a connection one of the two
    memory          lets glibc keep the memory of large messages for the next ones
    listeners       sockets that accept the connections of others
    dialler         connects to one node, again and again if that is asked for
    dials           all addresses and nodes that a session connects to
    flusher         sends the messages that links hold back while many are published
    backpressure    threads that wait until a link has room
    query_timer     ends the queries whose time is over
    relinking       restores the links after the process was stopped for a while
    fault_log       log lines about others that broke the rules
    native_session  the session: it opens, does what the protocol asks for, and closes

No thread is needed as long as somebody waits in the session's `wire_poller`, an executor for one; else the
session's one thread does.
"""
