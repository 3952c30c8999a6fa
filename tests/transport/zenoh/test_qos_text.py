"""QoS in liveliness tokens, against the examples of rmw_zenoh."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.errors import LocalError, RemoteError
from goalwire.rules.qos import (
    INFINITE_NS,
    PARAMETERS,
    ROSOUT,
    SENSOR_DATA,
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.transport.zenoh.qos_text import decode_qos, encode_qos

DURATIONS = st.integers(1, INFINITE_NS)


@pytest.mark.parametrize(
    ('qos', 'text'),
    [
        (QoS(), '::,10:,:,:,,'),
        (QoS(depth=42), '::,:,:,:,,'),
        (QoS(depth=0), '::,:,:,:,,'),
        (SENSOR_DATA, '2::,5:,:,:,,'),
        (QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL), ':1:,1:,:,:,,'),
        (QoS(depth=0, history=HistoryPolicy.KEEP_ALL), '::2,:,:,:,,'),
        (PARAMETERS, '::,1000:,:,:,,'),
        (ROSOUT, ':1:,1000:,:10,0:,,'),
        (QoS(depth=5, deadline_ns=1_500_000_000), '::,5:1,500000000:,:,,'),
        (QoS(depth=5, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, lease_ns=2), '::,5:,:,:3,0,2'),
        (QoS(depth=5, reliability=ReliabilityPolicy.BEST_AVAILABLE), '4::,5:,:,:,,'),
    ],
)
def test_only_what_differs_from_rmws_defaults_is_written(qos: QoS, text: str) -> None:
    assert encode_qos(qos) == text


@pytest.mark.parametrize(
    'qos',
    [
        QoS(reliability=ReliabilityPolicy.SYSTEM_DEFAULT),
        QoS(durability=DurabilityPolicy.SYSTEM_DEFAULT),
        QoS(history=HistoryPolicy.SYSTEM_DEFAULT),
        QoS(deadline_ns=INFINITE_NS, lifespan_ns=INFINITE_NS, lease_ns=INFINITE_NS),
        QoS(liveliness=LivelinessPolicy.AUTOMATIC),
    ],
)
def test_a_system_default_is_written_like_the_default(qos: QoS) -> None:
    assert encode_qos(qos) == encode_qos(QoS())


@pytest.mark.parametrize(
    'qos',
    [
        QoS(reliability=ReliabilityPolicy.UNKNOWN),
        QoS(durability=DurabilityPolicy.UNKNOWN),
        QoS(history=HistoryPolicy.UNKNOWN),
        QoS(liveliness=LivelinessPolicy.UNKNOWN),
    ],
)
def test_an_unknown_policy_cannot_be_declared(qos: QoS) -> None:
    with pytest.raises(LocalError, match='UNKNOWN'):
        encode_qos(qos)


def test_half_of_an_infinite_duration_stays_empty() -> None:
    """Seconds and nanoseconds are compared one by one."""
    assert encode_qos(QoS(depth=42, deadline_ns=9_223_372_036_000_000_001)) == '::,:,1:,:,,'


@given(
    st.builds(
        QoS,
        depth=st.integers(1, 10_000),
        history=st.sampled_from([HistoryPolicy.KEEP_LAST, HistoryPolicy.KEEP_ALL]),
        reliability=st.sampled_from([ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT]),
        durability=st.sampled_from([DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL]),
        deadline_ns=DURATIONS,
        lifespan_ns=DURATIONS,
        liveliness=st.sampled_from([LivelinessPolicy.AUTOMATIC, LivelinessPolicy.MANUAL_BY_TOPIC]),
        lease_ns=DURATIONS,
    )
)
def test_what_is_written_is_read(qos: QoS) -> None:
    assert decode_qos(encode_qos(qos)) == qos


@pytest.mark.parametrize(
    'text',
    ['', '::', '::,:,:,:,', 'x::,:,:,:,,', '9::,:,:,:,,', '::,-1:,:,:,,', '::,:,,:,:,,', '::,²:,:,:,,'],
)
def test_text_that_breaks_the_grammar_is_the_peers_fault(text: str) -> None:
    with pytest.raises(RemoteError):
        decode_qos(text)
