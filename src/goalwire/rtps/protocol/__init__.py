"""RTPS 2.5 as pure code: bytes and times go in, bytes and calls come out.

Nothing here opens a socket, starts a thread or reads a clock.

    bounds           how much a stranger can take: participants, endpoints, fragments, what waits
    primitives       GUIDs, sequence numbers, times, addresses: what submessages are made of
    messages         packets and submessages: written and read
    parameters       parameter lists and inline QoS: written and read
    qos              QoS of endpoints, and which of them match
    announcements    what participants and endpoints tell of themselves: written and read

What breaks the protocol raises RtpsError, and costs what is left of that packet.
"""
