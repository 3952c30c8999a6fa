"""Sockets for Zenoh's protocol, and the session that has them.

    settings        what a session is opened with
    endpoints       addresses such as tcp/localhost:7447
    socket_link     one connection: reads, writes, ends
    identities      who is at the other side of a link, by its certificate
    tls             the same with TLS on it
    link_maker      which of the two a connection gets
    memory          glibc keeps what large messages were read into
    listeners       sockets on which others are awaited
    dialler         connects to one node, again and again if that is asked for
    dials           all whom a session connects to
    flusher         sends what a flood holds back
    backpressure    threads that wait until a link has room
    query_timer     ends the queries whose time is over
    relinking       what happens after the process was stopped
    fault_log       log lines about others that broke the rules
    native_session  the session: it opens, does what the protocol asks for, and closes

No thread is needed as long as somebody waits in the session's `wire_poller`, an executor for one; else the
session's one thread does.
"""
