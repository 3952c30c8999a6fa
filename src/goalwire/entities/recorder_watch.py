"""Service events for recorders: published while a recorder asks for them, even if introspection is off.

Introspection is off in most programs, and a recorder cannot switch it on in them. So a recorder subscribes to
a topic of goalwire's own beside each service, and servers and clients that see such a subscription in the
graph publish there what introspection with CONTENTS would. While nobody subscribes, there is neither a
publisher nor anything to do for a call. docs/adr/026 says why it is done in this way.
"""

from __future__ import annotations

import os
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.entities.service_introspection import Introspected, ServiceIntrospection
from goalwire.errors import ClosedError, GoalwireError, ShutDownError
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.execution.weak_methods import weakly
from goalwire.logging import get_logger
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.transport.contract import GraphEntity

POSTFIX_FOR_RECORDERS = '/_service_event_for_recorders'
"""The end of the topic's name. Its messages are those of the service's `_service_event`."""
SWITCH = 'GOALWIRE_RECORDED_CALLS'
"""The environment variable; `off`: calls are published to no recorder."""
QOS = QoS(depth=1000)


class RecorderWatch:
    """Publishes the calls of one server or client while there is a recorder. Its owner must hold it, or it
    ends.
    """

    def __init__(self, owner: Introspected) -> None:
        self._owner = owner
        self._lock = Lock()
        self._recorders: set[bytes] = set()
        self._is_closed = False
        self._change = TimerEntry(weakly(self._follow))
        node = owner.node
        topic = node.resolve(owner.full_name + POSTFIX_FOR_RECORDERS)
        self._watch = node.graph.watch_counterparts(EndpointKind.PUBLISHER, topic, weakly(self._note))
        node.remains.add(self._watch.close)

    def _note(self, recorder: GraphEntity, is_there: bool) -> None:
        """Note that a recorder has come or gone. Runs on the graph's thread, which must not declare
        endpoints.
        """
        with self._lock:
            before = bool(self._recorders)
            if is_there:
                self._recorders.add(recorder.gid)
            else:
                self._recorders.discard(recorder.gid)
            if bool(self._recorders) == before or self._is_closed:
                return
        self._owner.node.context.sends.soon(self._change)

    def _follow(self) -> None:
        """Begin or stop publishing, as the recorders want it now. Only one thread calls this, and holds no
        lock.
        """
        with self._lock:
            is_wanted, current = bool(self._recorders), self._owner.recorded
        if is_wanted and current is None:
            self._replace(self._begin())
        elif not is_wanted:
            self._replace(None)

    def _replace(self, reporter: ServiceIntrospection | None) -> None:
        """Report calls to another publisher, and close the old one if it is not needed."""
        with self._lock:
            unused = reporter if self._is_closed else self._owner.recorded
            if not self._is_closed:
                self._owner.recorded = reporter
                self._owner.choose_reporter()
        if unused is not None:
            unused.close()

    def _begin(self) -> ServiceIntrospection | None:
        owner = self._owner
        try:
            return ServiceIntrospection(
                owner, owner.node.clock, QOS, contents=True, postfix=POSTFIX_FOR_RECORDERS
            )
        except (ClosedError, ShutDownError):
            return None  # the client or server is ending
        except GoalwireError as error:
            text = f"the calls of '{owner.full_name}' cannot be recorded: {error}"
            get_logger(owner.node.logger_name).warning(text)
            return None

    def close(self) -> None:
        """Stop publishing. Idempotent."""
        with self._lock:
            self._is_closed = True
            left, self._owner.recorded = self._owner.recorded, None
            self._owner.choose_reporter()
        if left is not None:
            left.close()
        self._owner.node.remains.discard(self._watch.close)
        self._watch.close()


def watch_recorders(owner: Introspected) -> None:
    """Have the calls of a server or client published while a recorder asks for them."""
    if os.environ.get(SWITCH, '').strip().lower() != 'off':
        owner.recorder_watch = RecorderWatch(owner)
