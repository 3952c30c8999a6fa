"""Publishes the health of a server once a second on /diagnostics, as diagnostic_updater does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from humanoid.clock import stamp
from humanoid.running import log_failure
from humanoid.text import brief

EVERY = 1.0  # s


@dataclass(frozen=True)
class Health:
    """OK, WARN, ERROR or STALE of DiagnosticStatus, a short text, and what was measured."""

    message: str = 'OK'
    level: bytes = DiagnosticStatus.OK
    values: Mapping[str, object] = field(default_factory=dict)


class Diagnostics:
    """Calls `check` once a second and publishes its result; an exception of `check` counts as ERROR."""

    def __init__(self, node: Node, what: str, check: Callable[[], Health]) -> None:
        self._node, self._check = node, check
        self._name = f'{node.get_fully_qualified_name()[1:]}: {what}'
        self._hardware = node.get_namespace().strip('/') or 'humanoid'
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        node.create_timer(EVERY, self._tell)

    def _tell(self) -> None:
        try:
            health = self._check()
        except Exception as error:
            log_failure(self._node, error)
            health = Health(brief(f'{type(error).__name__}: {error}'), DiagnosticStatus.ERROR)
        status = DiagnosticStatus(
            level=health.level,
            name=self._name,
            message=health.message,
            hardware_id=self._hardware,
            values=[KeyValue(key=key, value=str(value)) for key, value in health.values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = stamp(self._node)
        self._publisher.publish(message)
