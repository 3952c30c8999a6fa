"""How faults are switched on, and that they stand between a program and every method of a wire."""

from __future__ import annotations

import inspect
from unittest.mock import Mock

import pytest

from goalwire.errors import TransportError
from goalwire.transport import contract, registry
from goalwire.transport.contract import SessionOptions
from goalwire.transport.faults import (
    Delay,
    FailedCall,
    Faults,
    Kill,
    Kind,
    Loss,
    Partition,
    Point,
)
from goalwire.transport.faults.ports import (
    FaultyClient,
    FaultyPublisher,
    FaultyRequest,
    FaultyService,
    FaultySubscription,
)
from goalwire.transport.faults.session import FaultyNode, FaultySession
from goalwire.transport.faults.text import parse
from goalwire.transport.memory import TRANSPORT

from .conftest import Sides

WRAPPERS: dict[type, list[type]] = {
    contract.Session: [FaultySession],
    contract.NodePort: [FaultyNode],
    contract.PublisherPort: [FaultyPublisher],
    contract.ClientPort: [FaultyClient],
    contract.Request: [FaultyRequest],
    contract.Port: [FaultySubscription, FaultyService],
}
UNUSED = {
    (FaultyNode, 'watch_event'),
    (FaultyNode, 'peer_count'),
    *((wrapper, 'catch_up') for wrapper in (FaultyNode, FaultyPublisher, FaultyClient, FaultyService)),
}
"""A node has no events; a subscription alone catches up with what its wire holds."""


@pytest.mark.parametrize('interface', WRAPPERS)
def test_every_method_of_the_contract_is_wrapped(interface: type) -> None:
    methods = {name for name, _ in inspect.getmembers(interface, inspect.isfunction) if name[0] != '_'}
    assert methods
    for wrapper in WRAPPERS[interface]:
        ours = (base for base in wrapper.__mro__ if base.__module__.startswith('goalwire.transport.faults.'))
        wrapped = {name for base in ours for name in vars(base)}
        missing = {name for name in methods - wrapped if (wrapper, name) not in UNUSED}
        assert not missing, wrapper


def test_a_session_tells_of_itself_what_the_wires_own_tells() -> None:
    inner = TRANSPORT.open(SessionOptions())
    told = {'enforces_qos': True, 'compares_definitions': False, 'id': 'its own'}
    told |= {'refusals': Mock(), 'wire_poller': Mock()}
    assert set(told) == set(contract.Session.__annotations__) | {'enforces_qos', 'compares_definitions'}
    vars(inner).update(told)
    session = FaultySession(inner, Faults())
    assert {name: getattr(session, name) for name in told} == told
    session.close()


def test_a_with_block_puts_faults_on_what_is_opened_in_it() -> None:
    faults = Faults(FailedCall('transport.open'))
    with faults, pytest.raises(TransportError, match=r'transport\.open'):
        registry.get('goalwire_memory').open(SessionOptions())
    registry.get('goalwire_memory').open(SessionOptions()).close()


def test_the_environment_puts_faults_on_every_wire(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_FAULTS', 'failed_call transport.open nth=2')
    registry.get('goalwire_memory').open(SessionOptions()).close()
    with pytest.raises(TransportError, match=r'transport\.open'):
        registry.get('goalwire_memory').open(SessionOptions())


def test_faults_are_read_from_text() -> None:
    text = ' loss rate=0.1 name=/scan kind=request;seed 7 ; delay 0.02; partition a b one_way=yes; '
    text += 'kill arm goal_accepted'
    faults = parse(text)
    loss, delay, partition, kill = faults.active
    assert faults.seed == 7
    assert isinstance(loss, Loss)
    assert (loss.rate, loss.name, loss.kind) == (0.1, '/scan', Kind.REQUEST)
    assert isinstance(delay, Delay)
    assert delay.seconds == 0.02
    assert isinstance(partition, Partition)
    assert (partition.here, partition.there, partition.one_way) == ('/a', '/b', True)
    assert isinstance(kill, Kill)
    assert (kill.node, kill.point) == ('/arm', Point.GOAL_ACCEPTED)
    assert parse(text) is faults


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        ('rain', "'rain': there is no 'rain'; choose one of: seed, delay"),
        ('loss rate=2', 'a share from 0 to 1, got 2'),
        ('delay', "missing 1 required positional argument: 'seconds'"),
        ('loss wet=yes', "unexpected keyword argument 'wet'"),
        ('seed x', "there is no 'seed'"),
    ],
)
def test_text_that_is_no_fault_is_refused_with_the_reason(text: str, problem: str) -> None:
    with pytest.raises(TransportError, match=problem):
        parse(text)


def test_every_call_can_be_made_to_fail(sides: Sides, faults: Faults) -> None:
    alpha, _ = sides
    publisher = alpha.publisher('/chatter')
    fault = faults.add(FailedCall('publisher.publish', nth=2))
    publisher.publish(b'')
    with pytest.raises(TransportError, match=r'publisher\.publish'):
        publisher.publish(b'')
    publisher.publish(b'')
    assert (fault.struck, fault.struck_method) == (1, 'publisher.publish')
    faults.heal()
    assert faults.active == ()
