"""A receiver that raises takes nobody else down: neither the sender nor the transport's thread."""

from __future__ import annotations


def report_failure(where: str, error: Exception) -> None:
    """Log what the receiver at `where` raised."""
    from logging import getLogger  # heavy, and needed only when something is broken

    getLogger('goalwire.transport').error(
        '%s: its receiver raised; this delivery is lost', where, exc_info=error
    )
