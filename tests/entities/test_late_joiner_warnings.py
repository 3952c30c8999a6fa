"""A subscription that comes after the last message is told, and one that misses nothing is not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from threading import Thread

import pytest
from helpers.collector import Collector
from std_msgs.msg import String

from goalwire.entities import late_joiner_warnings
from goalwire.entities.node import NodeCore
from goalwire.entities.publisher import PublisherCore
from goalwire.entities.subscription import SubscriptionCore
from goalwire.execution.callback_groups import ReentrantCallbackGroup
from goalwire.execution.executors.spin_watch import SpinWatch
from goalwire.execution.time.timer import Timer
from goalwire.logging.dispatch import add_sink
from goalwire.logging.record import LogRecord
from goalwire.records import replace
from goalwire.rules.qos import DEFAULT, SENSOR_DATA, DurabilityPolicy, QoS
from goalwire.transport.contract import EndpointKind

KEPT = replace(DEFAULT, durability=DurabilityPolicy.TRANSIENT_LOCAL)
HELLO = String(data='hello')


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> Iterator[Collector[str]]:
    """The lines that are told about topics, after 50 ms."""
    monkeypatch.setattr(late_joiner_warnings, 'WAIT_S', 0.05)
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


def subscribe(node: NodeCore, topic: str, qos: QoS) -> SubscriptionCore[String]:
    return SubscriptionCore(node, String, topic, lambda _: None, qos, ReentrantCallbackGroup())


def begin_to_spin(node: NodeCore) -> None:
    """Do what executors do when they begin to spin without end on this thread."""
    SpinWatch(node.context.shutdown_signal, list).close()


def publish_before_spin(node: NodeCore, topic: str, qos: QoS) -> PublisherCore[String]:
    made = publisher(node, topic, qos)
    made.publish(HELLO)
    begin_to_spin(node)
    return made


def miss_one(node: NodeCore, told: Collector[str]) -> None:
    """Do what is told, on the thread that would have told what came before."""
    witness = NodeCore(node.context, 'witness')
    thread = Thread(target=publish_before_spin, args=[witness, 'missed', DEFAULT])
    thread.start()
    thread.join()
    subscribe(witness, 'missed', DEFAULT)
    [line] = told.expect(1)
    assert line.startswith("topic '/missed': 1 message was published before")


def publish_soon_again(node: NodeCore) -> None:
    lively = publish_before_spin(node, 'lively', DEFAULT)
    subscribe(node, 'lively', DEFAULT)
    lively.publish(HELLO)


def come_first(node: NodeCore) -> None:
    subscribe(node, 'first', DEFAULT)
    publish_before_spin(node, 'first', DEFAULT)
    subscribe(node, 'first', DEFAULT)


def ask_for_what_is_kept(node: NodeCore) -> None:
    publish_before_spin(node, 'kept', KEPT)
    subscribe(node, 'kept', KEPT)


def publish_nothing(node: NodeCore) -> None:
    publisher(node, 'silent', DEFAULT)
    begin_to_spin(node)
    subscribe(node, 'silent', DEFAULT)


def publish_events(node: NodeCore) -> None:
    """A button tells what happens, in a callback: the next message comes when the next thing happens."""
    button = publisher(node, 'button', KEPT)
    begin_to_spin(node)
    button.publish(HELLO)
    subscribe(node, 'button', DEFAULT)


def publish_changes(node: NodeCore) -> None:
    """A door tells its state at its start, and then each change, which is all that some want to know."""
    door = publish_before_spin(node, 'door', KEPT)
    door.publish(HELLO)
    subscribe(node, 'door', DEFAULT)


def publish_from_a_loop(node: NodeCore) -> None:
    """A thread publishes every ten seconds, while the main thread spins."""
    loop = publisher(node, 'loop', DEFAULT)
    thread = Thread(target=loop.publish, args=[HELLO])
    thread.start()
    thread.join()
    begin_to_spin(node)
    subscribe(node, 'loop', DEFAULT)


def publish_by_hand(node: NodeCore) -> None:
    """The thread that publishes waits for keys, and does not spin."""
    publisher(node, 'keys', DEFAULT).publish(HELLO)
    subscribe(node, 'keys', DEFAULT)


def publish_slowly(node: NodeCore) -> None:
    publish_before_spin(node, 'slow', DEFAULT)
    node.own(Timer(lambda: None, None, 10**10, node.clock))
    subscribe(node, 'slow', DEFAULT)


def publish_beside_another(node: NodeCore) -> None:
    publish_before_spin(node, 'shared', KEPT)
    publisher(node, 'shared', KEPT)
    subscribe(node, 'shared', DEFAULT)


def monitor(node: NodeCore) -> None:
    """A monitor takes whatever comes from now on, and is compatible with every publisher."""
    publish_before_spin(node, 'watched', KEPT)
    subscribe(node, 'watched', SENSOR_DATA)


def leave_again(node: NodeCore) -> None:
    publish_before_spin(node, 'left', KEPT)
    subscribe(node, 'left', DEFAULT).destroy()


def stop_publishing(node: NodeCore) -> None:
    stopped = publish_before_spin(node, 'stopped', KEPT)
    subscribe(node, 'stopped', DEFAULT)
    stopped.destroy()


def come_back(node: NodeCore) -> None:
    """The subscription was there in time; a link that is cut and mended shows it a second time."""
    subscribe(node, 'cut', DEFAULT)
    publish_before_spin(node, 'cut', KEPT)
    [seen] = node.graph.entities(EndpointKind.SUBSCRIPTION, '/cut')
    node.graph.vanished(seen)
    node.graph.appeared(seen)


@pytest.mark.parametrize(
    'do',
    [
        publish_soon_again, come_first, ask_for_what_is_kept, publish_nothing, publish_events,
        publish_changes, publish_from_a_loop, publish_by_hand, publish_slowly, publish_beside_another,
        monitor, leave_again, stop_publishing, come_back,
    ],
)  # fmt: skip
def test_what_misses_nothing_is_not_told(
    node: NodeCore, told: Collector[str], do: Callable[[NodeCore], None]
) -> None:
    do(node)
    miss_one(node, told)


def test_what_was_kept_and_is_not_asked_for_is_told(node: NodeCore, told: Collector[str]) -> None:
    publish_before_spin(node, 'map', KEPT)
    subscribe(node, 'map', DEFAULT)
    assert "topic '/map': the subscription in node '/node' came after the last message" in told.expect(1)[0]
