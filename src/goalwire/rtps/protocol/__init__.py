"""RTPS 2.5 as pure code: bytes and times go in, bytes and calls come out.

Nothing here opens a socket, starts a thread or reads a clock.

    bounds           how much a stranger can take: participants, endpoints, fragments, what waits
    primitives       GUIDs, sequence numbers, times, addresses: what submessages are made of
    messages         packets and submessages: written and read
    parameters       parameter lists and inline QoS: written and read
    qos              QoS of endpoints, and which of them match
    announcements    what participants and endpoints tell of themselves: written and read
    wire             what the following stand on: packets, timers, a lock, events for who listens
    history          what a writer keeps of what it has written
    fragments        samples that fit no packet: cut and joined
    reader_proxy     a reader, as its writer knows it
    writer_output    what a writer sends: fresh samples, heartbeats, gaps
    fragment_windows large samples, a window of fragments at a time
    repairs          what readers have acknowledged, and what they lack
    writer           a writer: all of these together
    backlog          what a reader keeps: samples that came too early, or in part
    reader           a reader: order, what is missing, liveliness
    matching         the writers and readers that are known, and which of them match
    discovery        participants that come and go (SPDP), and their endpoints (SEDP)
    participant      all of it together: `receive` takes each packet that comes

Threads. Every method of a participant, and those of writers and readers that say so, may be called on any
thread. All that changes a participant runs in `Wire.run`, alone; what users are told is called after that, in
order, without any lock.

What breaks the protocol raises RtpsError, and costs what is left of that packet.
"""
