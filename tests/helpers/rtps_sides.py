"""A session of RTPS in a test, and what its readers have got."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from types import TracebackType
from typing import Self

from helpers.patience import PATIENCE
from helpers.rtps_network import Collector, Publisher, Watcher

from goalwire.concurrency.wire_poller import SleepingThread
from goalwire.records import replace
from goalwire.rtps.io.addresses import Reach
from goalwire.rtps.io.session import RtpsSession, Settings
from goalwire.rtps.protocol.qos import RELIABLE, Qos
from goalwire.rtps.protocol.reader import Reader
from goalwire.rtps.protocol.writer import Writer

STRING = 'std_msgs::msg::dds_::String_'
STRING_HASH = b'typehash=RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18;'
_LOOK_AGAIN_NS = 2_000_000

RELIABLE_QOS = Qos(reliability=RELIABLE, depth=10)


def encode_string(text: str) -> bytes:
    """Return a std_msgs/String as DDS has it."""
    data = text.encode() + b'\0'
    return b'\0\1\0\0' + len(data).to_bytes(4, 'little') + data


def decode_string(payload: bytes | None) -> str:
    """Return the text of a std_msgs/String."""
    assert payload is not None
    return payload[8 : 7 + int.from_bytes(payload[4:8], 'little')].decode()


class Side:
    """One session; the test's thread reads its sockets while it waits."""

    def __init__(self, domain: int, reach: Reach = Reach.LOCALHOST, **settings: object) -> None:
        self.watcher = Watcher()
        chosen = replace(Settings(domain=domain, reach=reach, user_data=b'enclave=/;'), **settings)
        self.session = RtpsSession(chosen, self.watcher)
        self.participant = self.session.participant
        self._sleeper = SleepingThread()

    def writer(
        self, topic: str, qos: Qos = RELIABLE_QOS, type_name: str = STRING
    ) -> tuple[Writer, Publisher]:
        """Make a writer."""
        publisher = Publisher()
        return self.participant.create_writer(topic, type_name, qos, publisher, STRING_HASH), publisher

    def reader(
        self, topic: str, qos: Qos = RELIABLE_QOS, type_name: str = STRING
    ) -> tuple[Reader, Collector]:
        """Make a reader."""
        collector = Collector()
        collector.on_any = lambda _: self._sleeper.wake()
        return self.participant.create_reader(topic, type_name, qos, collector, STRING_HASH), collector

    def wait_for(self, condition: Callable[[], object], what: str = 'it', patience: float = PATIENCE) -> None:
        """Read what comes until something holds."""
        deadline = monotonic() + patience
        while not condition():
            assert monotonic() < deadline, f'waited in vain for {what}'
            self.session.wire_poller.wait(self._sleeper, _LOOK_AGAIN_NS)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.session.close()
