"""A subscription that comes after the last message is told, and one that misses nothing is not."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from helpers.collector import Collector
from std_msgs.msg import String

from goalwire.entities import late_joiners
from goalwire.entities.node import NodeCore
from goalwire.entities.publisher import PublisherCore
from goalwire.entities.subscription import SubscriptionCore
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.logging.dispatch import add_sink
from goalwire.logging.record import LogRecord
from goalwire.records import replace
from goalwire.rules.qos import DEFAULT, DurabilityPolicy, QoS

KEPT = replace(DEFAULT, durability=DurabilityPolicy.TRANSIENT_LOCAL)
HELLO = String(data='hello')


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> Iterator[Collector[str]]:
    """What is told, after 50 ms."""
    monkeypatch.setattr(late_joiners, 'WAIT_S', 0.05)
    lines: Collector[str] = Collector()

    def note(record: LogRecord) -> None:
        if record.message.startswith('topic '):
            lines(record.message)

    with add_sink(note):
        yield lines


def publisher(node: NodeCore, topic: str, qos: QoS) -> PublisherCore[String]:
    made: PublisherCore[String] = PublisherCore(node, String, topic, qos)
    made.tell_late_joiners()
    return made


def subscribe(node: NodeCore, topic: str, qos: QoS) -> None:
    SubscriptionCore(node, String, topic, lambda _: None, qos, ReentrantCallbackGroup())


def miss_one(node: NodeCore, told: Collector[str]) -> None:
    """Do what is told, on the thread that would have told what came before."""
    publisher(node, 'missed', DEFAULT).publish(HELLO)
    subscribe(node, 'missed', DEFAULT)
    [line] = told.expect(1)
    assert line.startswith("topic '/missed': 1 message was published before")


def publish_soon_again(node: NodeCore) -> None:
    lively = publisher(node, 'lively', DEFAULT)
    lively.publish(HELLO)
    subscribe(node, 'lively', DEFAULT)
    lively.publish(HELLO)


def come_first(node: NodeCore) -> None:
    subscribe(node, 'first', DEFAULT)
    publisher(node, 'first', DEFAULT).publish(HELLO)
    subscribe(node, 'first', DEFAULT)


def ask_for_what_is_kept(node: NodeCore) -> None:
    publisher(node, 'kept', KEPT).publish(HELLO)
    subscribe(node, 'kept', KEPT)


def publish_nothing(node: NodeCore) -> None:
    publisher(node, 'silent', DEFAULT)
    subscribe(node, 'silent', DEFAULT)


@pytest.mark.parametrize('do', [publish_soon_again, come_first, ask_for_what_is_kept, publish_nothing])
def test_what_misses_nothing_is_not_told(
    node: NodeCore, told: Collector[str], do: Callable[[NodeCore], None]
) -> None:
    do(node)
    miss_one(node, told)


def test_what_was_kept_and_is_not_asked_for_is_told(node: NodeCore, told: Collector[str]) -> None:
    publisher(node, 'map', KEPT).publish(HELLO)
    subscribe(node, 'map', DEFAULT)
    assert "topic '/map': the subscription in node '/node' came after the last message" in told.expect(1)[0]
