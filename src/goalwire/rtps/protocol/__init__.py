"""RTPS 2.5 as pure code: bytes and times go in, bytes and calls come out.

Nothing here opens a socket, starts a thread or reads a clock.

    bounds           limits of what others can use: participants, endpoints, fragments, queues
    primitives       GUIDs, sequence numbers, times, addresses: the parts of submessages
    messages         packets and submessages: written and read
    parameters       parameter lists and inline QoS: written and read
    qos              QoS of endpoints, and if a writer and a reader match
    announcements    discovery data of participants and endpoints: written and read
    wire the base of the following modules: packets, timers, a lock, events for listeners
    history          the samples that a writer keeps
    fragments        samples larger than a packet: cut and joined
    reader_proxy     a writer's record of one of its readers
    writer_output    what a writer sends: fresh samples, heartbeats, gaps
    fragment_windows large samples, a window of fragments at a time
    repairs          samples that readers have acknowledged, and samples that they lack
    writer           a writer: all of these together
    backlog          the samples that a reader keeps: early ones, and incomplete ones
    reader           a reader: order, missing samples, liveliness
    matching         the known writers and readers, and which of them match
    discovery        participants that appear and disappear (SPDP), and their endpoints (SEDP)
    participant a participant: all of these together; `receive` takes each packet

Threads. Every method of a participant, and those of writers and readers that say so, may be called on any
thread. All changes of a participant run in `Wire.run`, one at a time; users' callbacks run after that, in
order, without any lock.

Data that breaks the protocol raises RtpsError, and the rest of its packet is ignored.
"""
