"""Zenoh's protocol, version 9, without I/O: takes bytes and times, returns bytes and makes calls.

Nothing here opens a socket, starts a thread or reads a clock. A session (`session_protocol.SessionProtocol`)
has links (`link.Link`). The owner of the sockets hands each link the bytes that were read. The links call it
to write (`outgoing.Connection`), the session to connect and to close (`session_protocol.SessionOwner`). Users
declare entities at the session, and send by a publication (`publication`) or a querier (`querier`).

The parts of messages:

    bounds            limits of the resources that a peer can use: keys, entries, fragments, dials, log lines
    primitives        numbers, texts, ids, extensions, timestamps
    shared_memory     pointers to payloads in shared memory, and the marks of messages that have them
    link_messages     INIT, OPEN, CLOSE, KEEP_ALIVE: encoding and decoding
    bodies            PUT, DEL and QUERY: encoding and decoding
    network           PUSH, REQUEST, RESPONSE, RESPONSE_FINAL, which have bodies: encoding and decoding
    declarations      DECLARE and INTEREST: encoding and decoding
    link_state        OAM, by which routers announce nodes; the rule which of two peers connects
    forms             remembered beginnings of messages, by which similar ones are read in one step

One link:

    handshake         two sides agree on their terms
    channels          sequence numbers, fragments, and the queue before the socket
    frames            the receiving half: cuts bytes into frames and pieces, and these into messages
    outgoing          the sending half: numbers, frames, backpressure, keep-alives
    peer_entities     the other side's declarations, within bounds
    payloads          payloads that the other side has left in shared memory
    guard             the permissions of the other side, if links have certificates
    link              the link itself: hands network messages on, and checks the other side's lease

One session:

    key_expressions   the matching of keys: intersects, includes, canonical forms
    key_index         an index of expressions, which finds those that match a key quickly
    expressions       the short numbers of keys
    links             the links that are up, one to each other session
    liveliness_tokens  the tokens that exist, and the watchers that are told of changes
    queries           a query that was sent, its replies and its end
    pending_queries   the queries that were sent, by number, and their timeouts
    incoming_queries  a received query, and its answers
    routes            the receivers of the messages and queries that come over a link
    own_entities      the session's declarations, and the links that were told of them
    router_interests  the entities that a session asks routers for
    gossip            the nodes that routers have announced
    stamps            timestamps, each later than every earlier one
    publication       publications, each for one key
    querier           queriers, each for one key
    session_protocol  the session itself: keeps its own and its peers' declarations in step

A router for one machine:

    introductions     each peer is told where the others listen
    relayed_entities  the entities of the router's links, and the links that have been told of them
    router_link       a link of the router, which hands messages on as they came
    router_protocol   the router itself: it introduces peers, and serves clients

Threads. Every method may be called on any thread, but what one link receives is handed to it by one thread at
a time. `SessionProtocol.section` guards the tables of a session and of its links' declarations.
`Outgoing.section` guards the sending of a link: the number of a frame, its place in the queue, the write.
Code that holds both took the session's first. Neither is held while a user's function runs, nor while a
thread waits. Code that runs for each message reads a few tables without the lock. These tables are dicts and
tuples that are replaced or changed in one step.

Bytes that break the protocol raise ZenohProtocolError out of `FrameReader.receive`, and end that link only.
"""
