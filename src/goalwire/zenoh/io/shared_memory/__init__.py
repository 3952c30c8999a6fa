"""Zenoh's shared memory: payloads that processes on one machine hand over by pointers.

A session that publishes has a pool: data segments with chunks in them, and one metadata segment with a header
for each chunk that is lent. It tells a reader the header's place; the reader opens both segments by their
numbers, copies the payload out or keeps a view, and lowers the count in the header. The count at 0 means that
the chunk is free.

    layout            what the segments hold, byte for byte
    segments          files in /dev/shm: made, opened, locked, swept
    agreement         how two sides agree, in INIT and OPEN
    allocator         where a data segment is free
    pool              the writer: chunks, headers, who holds which
    lender            the writer's side of one link: probes, its share, oddities
    reader            the reader's side of one link
    session_memory    all of one session: whether to offer it, its segments, its end

The writer needs no atomic instruction. It lends each header to one link only, with a count of 1, and from
then on only reads it: a header is free at 0, or when the process at the other end is gone. It never takes a
chunk back by time, as Zenoh's own writers do. Readers of goalwire's own writers need none either, as nobody
else counts in their header. To read what others write takes the package `atomicshm`.

Source: eclipse-zenoh 1.9.0 and 1.10.2, commons/zenoh-shm, and ext/shm.rs of zenoh-transport's establishment.
"""
