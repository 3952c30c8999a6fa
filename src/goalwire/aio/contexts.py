"""The contexts of nodes that are given none: one for each domain, as long as the process has a node there."""

from __future__ import annotations

from threading import Lock

from goalwire.entities.context import Context, domain_from_environment


class SharedContexts:
    """Opens a context for the first node of a domain and ends it after the last."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._users: dict[Context, int] = {}

    def take(self, domain: int | None) -> Context:
        """Return the context of a domain (ROS_DOMAIN_ID's where None); `release` it after use. Any thread.

        It reads the program's ROS arguments, and leaves signals alone. Raises RCLError for bad arguments.
        """
        number = domain_from_environment() if domain is None else domain
        with self._lock:
            for context in self._users:
                if context.ok() and context.get_domain_id() == number:
                    break
            else:
                context = Context()
                context.init(domain_id=number)
            self._users[context] = self._users.get(context, 0) + 1
        return context

    @property
    def open(self) -> int:
        """How many contexts are open."""
        return len(self._users)

    def release(self, context: Context) -> None:
        """One node less needs it. Any thread; it may take as long as the wire takes to close."""
        with self._lock:
            self._users[context] -= 1
            if self._users[context]:
                return
            del self._users[context]
        context.try_shutdown()


CONTEXTS = SharedContexts()
"""Those of this process."""
