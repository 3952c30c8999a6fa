"""The handler has run, its answer never arrives: what cannot be told from a request that was lost."""

from __future__ import annotations

from dataclasses import dataclass

from goalwire.transport.faults.loss import Loss
from goalwire.transport.faults.packet import Kind


@dataclass(eq=False)
class LostReply(Loss):
    """Replies alone are lost."""

    strikes_on = frozenset({Kind.REPLY})
