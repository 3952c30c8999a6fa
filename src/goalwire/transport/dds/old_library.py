"""What libddsc 0.10 (ROS 2 Humble to Kilted) does not offer and 11.0 does."""

from __future__ import annotations

from contextlib import ExitStack
from ctypes import c_void_p

from goalwire.transport.dds.abi import ANY_STATE, SampleInfo
from goalwire.transport.dds.wire import Participant, check

_PARTITION = b'goalwire_type_inside'
_TOPIC = 'goalwire_type_inside'
_TYPE_OFFSET = 24
"""Bytes before the pointer to its type in a serialized sample (struct ddsi_serdata)."""


def serdata_type(participant: Participant, type_name: str) -> int:
    """Return the library's own handle of a type: that which a sample of it carries.

    All topics of one type share it. The sample is written and read on a topic and in a partition of its own,
    so that nobody else sees it, or takes it for one whose QoS does not fit.
    """
    library, parent = participant.library, participant.handle
    with ExitStack() as undo:
        topic = participant.topic(_TOPIC, type_name)
        undo.callback(library.dds_delete, topic)
        qos = library.dds_create_qos()
        undo.callback(library.dds_delete_qos, qos)
        library.dds_qset_partition1(qos, _PARTITION)
        publisher = check(library, library.dds_create_publisher(parent, qos, None), 'publisher')
        undo.callback(library.dds_delete, publisher)
        subscriber = check(library, library.dds_create_subscriber(parent, qos, None), 'subscriber')
        undo.callback(library.dds_delete, subscriber)
        reader = check(library, library.dds_create_reader(subscriber, topic, None, None), 'reader')
        writer = check(library, library.dds_create_writer(publisher, topic, None, None), 'writer')
        check(library, library.dds_write(writer, b'\0'), 'write')
        samples, infos = (c_void_p * 1)(), (SampleInfo * 1)()
        if library.dds_takecdr(reader, samples, 1, infos, ANY_STATE) != 1 or not samples[0]:
            check(library, -1, 'a sample of its own')
        sample = samples[0] or 0
        try:
            return c_void_p.from_address(sample + _TYPE_OFFSET).value or 0
        finally:
            library.ddsi_serdata_unref(sample)
