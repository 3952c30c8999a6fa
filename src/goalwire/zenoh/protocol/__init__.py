"""Zenoh's protocol, version 9, as pure code: bytes and times go in, bytes and calls come out.

Nothing here opens a socket, starts a thread or reads a clock. A session
(`session_protocol.SessionProtocol`) has links (`link.Link`). Whoever has the sockets hands each link what it
read, and is told what to do: to write (`outgoing.Connection`), to connect and to close
(`session_protocol.SessionOwner`). What a user asks for is a declaration of the session, or a publication or
querier (`senders`).

What messages are made of:

    bounds            how much a peer can take: keys, entries, fragments, dials, log lines
    primitives        numbers, texts, ids, extensions, timestamps
    shared_memory     pointers to payloads in shared memory, and how messages mark them
    transport         INIT, OPEN, CLOSE, KEEP_ALIVE: written and read
    network           PUSH, REQUEST, RESPONSE, RESPONSE_FINAL: written and read
    declarations      DECLARE and INTEREST: written and read
    link_state        OAM, by which routers tell of nodes; which of two peers connects
    forms             what repeats in requests, replies and messages, read in one step

One link:

    handshake         two sides agree on their terms
    channels          sequence numbers, fragments, and what waits for the socket
    frames            the receiving half: bytes are cut into frames and pieces, and those into messages
    outgoing          the sending half: numbers, frames, what waits for room, keep-alives
    peer_entities     what the other side has declared, within bounds
    payloads          payloads that the other side has left in shared memory
    guard             what the other side may do, where links have certificates
    link              the link itself: network messages are handed on; the other side's lease

One session:

    key_expressions   which keys match which: intersects, includes, canonical forms
    key_index         many expressions, and quickly those that match one key
    expressions       the short numbers of keys
    links             the links that are up, one to each other session
    liveliness_tokens  which tokens are there, and who is told
    queries           a query on its way, its replies and its end
    pending_queries   the queries on their way, by number, and their time
    incoming_queries  a query that came, and its answers
    routes            who gets what comes over a link
    own_entities      what the session has declared, and who was told of it
    gossip            the nodes that routers told of
    stamps            timestamps, each later than all before it
    senders           publications and queriers, each for one key
    session_protocol  the session itself: what is declared here and there, kept in step

A router for one machine:

    introductions     each peer is told where the others listen
    relayed_entities  the entities of the router's links, and the links that have been told of them
    router_link       a link of the router, which hands messages on as they came
    router_protocol   the router itself: it introduces peers, and serves clients

Threads. Every method may be called on any thread, but what one link receives is handed to it by one thread
at a time. `SessionProtocol.section` is over the tables of a session and of what its links have declared;
`Outgoing.section` over what a link sends: the number of a frame, its place in the queue, the write. Whoever
holds both took the session's first. Neither is held while a user's function runs, nor while anybody waits.
A few tables are read without the lock by what runs for each message. Those are dicts and tuples that are
replaced or changed in one step.

Bytes that break the protocol raise ZenohProtocolError out of `FrameReader.receive`, and end that link only.
"""
