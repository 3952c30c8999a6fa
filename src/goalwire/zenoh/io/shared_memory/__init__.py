"""Zenoh's shared memory: payloads that processes on one machine hand over by pointers.

A session that publishes has a pool: data segments with chunks in them, and one metadata segment with a header
for each chunk that is lent. It sends a reader the place of the header. The reader opens both segments by
their numbers, copies the payload or keeps a view of it, and lowers the count in the header. A count of 0
means that the chunk is free.

    layout            the content of the segments, byte for byte
    segments          files in /dev/shm: made, opened, locked, swept
    agreement         the negotiation of two sides, in INIT and OPEN
    allocator         finds free places in a data segment
    pool              the writer: chunks, headers, and which reader holds which chunk
    lender            the writer's side of one link: tests that the reader can read, then lends
    reader            the reader's side of one link
    session_memory    the shared memory of one session: when it is offered, its segments, its end

The writer needs no atomic instruction. It lends each header to one link only, with a count of 1, and from
then on only reads it: a header is free at 0, or when the process at the other end is gone. It never takes a
chunk back by time, as Zenoh's own writers do. Readers of goalwire's own writers need none either, as no other
reader counts in the same header. Reading the memory of other writers needs the package `atomicshm`.

Source: eclipse-zenoh 1.9.0 and 1.10.2, commons/zenoh-shm, and ext/shm.rs of zenoh-transport's establishment.
"""
