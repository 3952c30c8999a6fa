"""Tasks and a publisher that watch the frequency and the stamps of a topic's messages."""

from __future__ import annotations

from typing import Any

from rclpy.publisher import Publisher
from rclpy.time import Time

from diagnostic_updater._diagnostic_updater import CompositeDiagnosticTask, Updater
from diagnostic_updater._update_functions import (
    FrequencyStatus,
    FrequencyStatusParam,
    TimeStampStatus,
    TimeStampStatusParam,
)

__all__ = ['DiagnosedPublisher', 'HeaderlessTopicDiagnostic', 'TopicDiagnostic']


class HeaderlessTopicDiagnostic(CompositeDiagnosticTask):
    """A task of an updater that watches the frequency of messages without a header."""

    def __init__(self, name: str, diag: Updater, freq: FrequencyStatusParam) -> None:
        super().__init__(f'{name} topic status')
        self.diag = diag
        self.freq = FrequencyStatus(freq)
        self.addTask(self.freq)
        diag.add(self)

    def tick(self) -> None:
        """Count a message."""
        self.freq.tick()

    def clear_window(self) -> None:
        """Forget the messages counted so far."""
        self.freq.clear()


class TopicDiagnostic(HeaderlessTopicDiagnostic):
    """A task of an updater that watches the frequency of messages, and the age of their stamps."""

    def __init__(
        self, name: str, diag: Updater, freq: FrequencyStatusParam, stamp: TimeStampStatusParam
    ) -> None:
        super().__init__(name, diag, freq)
        self.stamp = TimeStampStatus(stamp, clock=diag.node.get_clock())
        self.addTask(self.stamp)

    def tick(self, stamp: Time | float) -> None:  # type: ignore[override]  # upstream's: a stamp is needed
        """Count a message with its stamp: a Time, or a number of seconds."""
        self.stamp.tick(stamp)
        super().tick()


class DiagnosedPublisher(TopicDiagnostic):
    """Wraps a publisher of messages with headers, and watches what it publishes."""

    def __init__(
        self, pub: Publisher[Any], diag: Updater, freq: FrequencyStatusParam, stamp: TimeStampStatusParam
    ) -> None:
        super().__init__(pub.topic_name, diag, freq, stamp)
        self.publisher = pub

    def publish(self, message: Any) -> None:
        """Count a message with its header's stamp, and publish it."""
        self.tick(Time.from_msg(message.header.stamp))
        self.publisher.publish(message)
