"""libddsc's C interface, as far as it is used here: structures and functions.

Layouts are those of Cyclone DDS 0.10 and 11.0 (dds.h, dds_public_impl.h, ddsi_serdata.h); library.py tests
the loaded library against them. Functions that may block let other Python threads run (CDLL). Short
functions that each message needs do not (PyDLL): they hold the library's locks for moments, and no thread
that holds such a lock waits for the GIL. No callback is handed to the library, so none of its threads waits
for the interpreter.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from ctypes import (
    c_bool,
    c_char_p,
    c_int32,
    c_int64,
    c_size_t,
    c_ssize_t,
    c_uint16,
    c_uint32,
    c_uint64,
    c_void_p,
)
from typing import TypeAlias

Function: TypeAlias = Callable[..., int]

INFINITY = 2**63 - 1
ANY_STATE = 127
ALIVE = 16
PUBLICATIONS, SUBSCRIPTIONS, PARTICIPANTS = 0x7FFF0003, 0x7FFF0004, 0x7FFF0001
SERIALIZED_DATA = 2
TIMEOUT = -10

GUID_SIZE = 16
Guid = ctypes.c_ubyte * GUID_SIZE


class TypeMeta(ctypes.Structure):
    """dds_type_meta_ser: serialized type information; always empty here."""

    _fields_ = [('data', c_void_p), ('size', c_uint32)]


class TopicDescriptor(ctypes.Structure):
    """dds_topic_descriptor_t."""

    _fields_ = [
        ('size', c_uint32),
        ('align', c_uint32),
        ('flags', c_uint32),
        ('key_count', c_uint32),
        ('type_name', c_char_p),
        ('keys', c_void_p),
        ('op_count', c_uint32),
        ('ops', ctypes.POINTER(c_uint32)),
        ('meta', c_char_p),
        ('type_information', TypeMeta),
        ('type_mapping', TypeMeta),
        ('representations', c_uint32),
    ]


class SampleInfo(ctypes.Structure):
    """dds_sample_info_t."""

    _fields_ = [
        ('sample_state', c_int32),
        ('view_state', c_int32),
        ('instance_state', c_int32),
        ('valid_data', c_bool),
        ('source_timestamp', c_int64),
        ('instance_handle', c_uint64),
        ('publication_handle', c_uint64),
        ('disposed_generation_count', c_uint32),
        ('no_writers_generation_count', c_uint32),
        ('sample_rank', c_uint32),
        ('generation_rank', c_uint32),
        ('absolute_generation_rank', c_uint32),
    ]


class BuiltinParticipant(ctypes.Structure):
    """dds_builtintopic_participant_t."""

    _fields_ = [('key', Guid), ('qos', c_void_p)]


class BuiltinEndpoint(ctypes.Structure):
    """dds_builtintopic_endpoint_t."""

    _fields_ = [
        ('key', Guid),
        ('participant', Guid),
        ('participant_handle', c_uint64),
        ('topic_name', c_char_p),
        ('type_name', c_char_p),
        ('qos', c_void_p),
    ]


class Piece(ctypes.Structure):
    """ddsrt_iovec_t: a piece of memory."""

    _fields_ = (
        [('size', c_uint32), ('base', c_void_p)]
        if sys.platform == 'win32'
        else [('base', c_void_p), ('size', c_size_t)]
    )


class Counts(ctypes.Structure):
    """A status that begins with a total and its change; `extra` has the other fields, if there are any."""

    _fields_ = [('total', c_uint32), ('change', c_int32), ('extra', c_uint32 * 6)]


class AliveCounts(ctypes.Structure):
    """dds_liveliness_changed_status_t."""

    _fields_ = [
        ('alive', c_uint32),
        ('not_alive', c_uint32),
        ('alive_change', c_int32),
        ('not_alive_change', c_int32),
        ('handle', c_uint64),
    ]


class PacketPiece(ctypes.Structure):
    """struct ddsi_rdata of 11.0: a piece of a received sample, and where it is in its packet."""

    _fields_ = [
        ('packet', c_void_p),
        ('next', c_void_p),
        ('first', c_uint32),
        ('end', c_uint32),
        ('submessage', c_uint16),
        ('payload', c_uint16),
    ]


PACKET_START = 48
"""The offset in bytes of a packet in the library's receive buffer (struct ddsi_rmsg of 11.0)."""

_P = c_void_p
_I = c_int32
_CREATE = (_I, _I, _P, _P)

_RELEASING: dict[str, tuple[type | None, tuple[type, ...]]] = {
    'dds_create_domain': (_I, (c_uint32, c_char_p)),
    'dds_create_participant': (_I, (c_uint32, _P, _P)),
    'dds_create_publisher': (_I, (_I, _P, _P)),
    'dds_create_subscriber': (_I, (_I, _P, _P)),
    'dds_create_topic': (_I, (_I, ctypes.POINTER(TopicDescriptor), c_char_p, _P, _P)),
    'dds_create_writer': (_I, _CREATE),
    'dds_create_reader': (_I, _CREATE),
    'dds_create_readcondition': (_I, (_I, c_uint32)),
    'dds_create_guardcondition': (_I, (_I,)),
    'dds_create_waitset': (_I, (_I,)),
    'dds_waitset_attach': (_I, (_I, _I, c_ssize_t)),
    'dds_waitset_detach': (_I, (_I, _I)),
    'dds_waitset_wait': (_I, (_I, _P, c_size_t, c_int64)),
    'dds_delete': (_I, (_I,)),
    'dds_write': (_I, (_I, _P)),
    'dds_writecdr': (_I, (_I, _P)),
    'dds_take': (_I, (_I, ctypes.POINTER(_P), ctypes.POINTER(SampleInfo), c_size_t, c_uint32)),
    'dds_return_loan': (_I, (_I, ctypes.POINTER(_P), _I)),
    'dds_set_status_mask': (_I, (_I, c_uint32)),
    'dds_take_status': (_I, (_I, ctypes.POINTER(c_uint32), c_uint32)),
    'dds_get_matched_subscriptions': (_I, (_I, ctypes.POINTER(c_uint64), c_size_t)),
    'dds_get_matched_publications': (_I, (_I, ctypes.POINTER(c_uint64), c_size_t)),
    'dds_get_matched_subscription_data': (_P, (_I, c_uint64)),
    'dds_get_matched_publication_data': (_P, (_I, c_uint64)),
    'dds_wait_for_acks': (_I, (_I, c_int64)),
    'dds_assert_liveliness': (_I, (_I,)),
}
_HOLDING: dict[str, tuple[type | None, tuple[type, ...]]] = {
    'dds_set_guardcondition': (_I, (_I, c_bool)),
    'dds_takecdr': (_I, (_I, _P, c_uint32, _P, c_uint32)),
    'dds_builtintopic_free_endpoint': (None, (_P,)),
    'dds_create_qos': (_P, ()),
    'dds_delete_qos': (None, (_P,)),
    'dds_free': (None, (_P,)),
    'dds_get_guid': (_I, (_I, ctypes.POINTER(Guid))),
    'dds_get_instance_handle': (_I, (_I, ctypes.POINTER(c_uint64))),
    'dds_get_entity_sertype': (_I, (_I, ctypes.POINTER(_P))),
    'dds_strretcode': (c_char_p, (_I,)),
    'dds_qset_deadline': (None, (_P, c_int64)),
    'dds_qset_durability': (None, (_P, _I)),
    'dds_qset_durability_service': (None, (_P, c_int64, _I, _I, _I, _I, _I)),
    'dds_qset_history': (None, (_P, _I, _I)),
    'dds_qset_ignorelocal': (None, (_P, _I)),
    'dds_qset_lifespan': (None, (_P, c_int64)),
    'dds_qset_liveliness': (None, (_P, _I, c_int64)),
    'dds_qset_partition1': (None, (_P, c_char_p)),
    'dds_qset_reliability': (None, (_P, _I, c_int64)),
    'dds_qset_userdata': (None, (_P, c_char_p, c_size_t)),
    'dds_qset_writer_data_lifecycle': (None, (_P, c_bool)),
    'dds_qget_deadline': (c_bool, (_P, _P)),
    'dds_qget_durability': (c_bool, (_P, _P)),
    'dds_qget_history': (c_bool, (_P, _P, _P)),
    'dds_qget_lifespan': (c_bool, (_P, _P)),
    'dds_qget_liveliness': (c_bool, (_P, _P, _P)),
    'dds_qget_reliability': (c_bool, (_P, _P, _P)),
    'dds_qget_prop': (c_bool, (_P, c_char_p, _P)),
    'dds_qget_userdata': (c_bool, (_P, _P, _P)),
    'ddsi_serdata_from_ser_iov': (
        _P,
        (_P, _I, c_uint32 if sys.platform == 'win32' else c_size_t, _P, c_size_t),
    ),
    'ddsi_serdata_size': (c_uint32, (_P,)),
    'ddsi_serdata_to_ser': (None, (_P, c_size_t, c_size_t, _P)),
    'ddsi_serdata_to_ser_ref': (_P, (_P, c_size_t, c_size_t, ctypes.POINTER(Piece))),
    'ddsi_serdata_to_ser_unref': (None, (_P, ctypes.POINTER(Piece))),
    'ddsi_serdata_unref': (None, (_P,)),
}
_STATUSES = (
    'liveliness_changed',
    'liveliness_lost',
    'offered_deadline_missed',
    'offered_incompatible_qos',
    'publication_matched',
    'requested_deadline_missed',
    'requested_incompatible_qos',
    'sample_lost',
    'subscription_matched',
)
_MISSING_IN_0_10 = frozenset({'dds_get_entity_sertype'})


class Library:
    """The functions of one loaded library, under their C names."""

    dds_assert_liveliness: Function
    dds_builtintopic_free_endpoint: Function
    dds_create_domain: Function
    dds_create_guardcondition: Function
    dds_create_participant: Function
    dds_create_publisher: Function
    dds_create_qos: Function
    dds_create_readcondition: Function
    dds_create_reader: Function
    dds_create_subscriber: Function
    dds_create_topic: Function
    dds_create_waitset: Function
    dds_create_writer: Function
    dds_delete: Function
    dds_delete_qos: Function
    dds_free: Function
    dds_get_guid: Function
    dds_get_instance_handle: Function
    dds_get_matched_publication_data: Function
    dds_get_matched_publications: Function
    dds_get_matched_subscription_data: Function
    dds_get_matched_subscriptions: Function
    dds_qget_deadline: Function
    dds_qget_durability: Function
    dds_qget_history: Function
    dds_qget_lifespan: Function
    dds_qget_liveliness: Function
    dds_qget_prop: Function
    dds_qget_reliability: Function
    dds_qget_userdata: Function
    dds_qset_deadline: Function
    dds_qset_durability: Function
    dds_qset_durability_service: Function
    dds_qset_history: Function
    dds_qset_ignorelocal: Function
    dds_qset_lifespan: Function
    dds_qset_liveliness: Function
    dds_qset_partition1: Function
    dds_qset_reliability: Function
    dds_qset_userdata: Function
    dds_qset_writer_data_lifecycle: Function
    dds_return_loan: Function
    dds_set_guardcondition: Function
    dds_set_status_mask: Function
    dds_strretcode: Callable[[int], bytes]
    dds_take: Function
    dds_take_status: Function
    dds_takecdr: Function
    dds_wait_for_acks: Function
    dds_waitset_attach: Function
    dds_waitset_detach: Function
    dds_waitset_wait: Function
    dds_write: Function
    dds_writecdr: Function
    ddsi_serdata_from_ser_iov: Function
    ddsi_serdata_size: Function
    ddsi_serdata_to_ser: Function
    ddsi_serdata_to_ser_ref: Function
    ddsi_serdata_to_ser_unref: Function
    ddsi_serdata_unref: Function
    dds_get_entity_sertype: Function | None
    from_large: Function
    """ddsi_serdata_from_ser_iov, called without the GIL, so that other Python threads run."""

    def __init__(self, path: str) -> None:
        """Load the library. Raises OSError if that fails, AttributeError if a function is missing."""
        self.path = path
        releasing = {f'dds_get_{name}_status': (_I, (_I, _P)) for name in _STATUSES}
        for loaded, table in (
            (ctypes.CDLL(path), {**_RELEASING, **releasing}),
            (ctypes.PyDLL(path), _HOLDING),
        ):
            for name, (result, arguments) in table.items():
                setattr(self, name, _bind(loaded, name, result, arguments))
        make = 'ddsi_serdata_from_ser_iov'
        self.from_large = getattr(ctypes.CDLL(path), make)
        self.from_large.restype, self.from_large.argtypes = _HOLDING[make]  # type: ignore[attr-defined]

    def status(self, name: str) -> Function:
        """Return the library's function that reads the status of this name, such as 'publication_matched'."""
        function: Function = getattr(self, f'dds_get_{name}_status')
        return function


def _bind(
    library: ctypes.CDLL, name: str, result: type | None, arguments: tuple[type, ...]
) -> Function | None:
    if name in _MISSING_IN_0_10 and not hasattr(library, name):
        return None
    function = getattr(library, name)
    function.restype = result
    function.argtypes = arguments
    bound: Function = function
    return bound
