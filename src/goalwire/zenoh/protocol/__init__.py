"""Zenoh's protocol, version 9, as pure code: bytes and times go in, bytes and calls come out.

Nothing here opens a socket, starts a thread or reads a clock. A session (`session.SessionProtocol`) owns its
links (`link.Link`). Whoever owns the sockets hands each link what it read, and gives it a function that
writes. What a user asks for, a put, a query, a declaration, is a method of the session.

    bounds            how much a peer can take: keys, entries, fragments, dials, log lines
    primitives        numbers, texts, ids, extensions, timestamps: what messages are made of
    key_expressions   which keys match which: intersects, includes, canonical forms
    key_index         many expressions, and quickly those that match one key
    transport         INIT, OPEN, CLOSE, KEEP_ALIVE: written and read
    handshake         two sides agree on their terms
    channels          sequence numbers, fragments, and what waits for the socket
    network           PUSH, REQUEST, RESPONSE, RESPONSE_FINAL: written and read
    declarations      DECLARE and INTEREST: written and read
    expressions       the short numbers of keys
    liveliness        tokens: which are there, and who is told
    link_state        OAM, by which routers tell of nodes; which of two peers connects
    forms             what repeats in requests, replies and messages, read in one step
    link              one link: reads the frames and fragments that come; the other side's lease
    outgoing          the sending half of a link: numbers, frames, what waits for room, keep-alives
    queries           queries on their way, their replies and their ends
    senders           publications and queriers, each for one key
    stamps            timestamps of a session, each later than all before it
    session           all declarations, of this side and of others, and the routing of messages

Threads. Every method may be called on any thread, but what one link receives is handed to it by one thread
at a time. `SessionProtocol.section` is over the tables of a session and of what its links have declared;
`Outgoing.section` over what a link sends: the number of a frame, its place in the queue, the write. Whoever
holds both took the session's first. Neither is held while a user's function runs, nor while anybody waits.
A few tables are read without the lock by what runs for each message. Those are dicts and tuples that are
replaced or changed in one step.

What breaks the protocol raises ZenohProtocolError out of `Link.receive`, and ends that link alone.
"""
