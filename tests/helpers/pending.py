"""The entries that wait in the tables of a node's clients, down to the wire."""

from __future__ import annotations

import time

from helpers.patience import PATIENCE

from goalwire.entities.actions.client import ActionClientCore
from goalwire.entities.client import ClientCore
from goalwire.entities.node import NodeCore
from goalwire.transport.contract import ClientPort

_TABLES = ('_calls', 'waiting')
"""The names of the tables in the wires' clients."""


def left_pending(node: NodeCore) -> dict[str, int]:
    """Return what is still in the tables of a node whose calls have all ended.

    A wire's own end of a call may follow its answer by some milliseconds, and nothing tells of that.
    """
    deadline = time.monotonic() + PATIENCE
    while (found := pending(node)) and time.monotonic() < deadline:
        time.sleep(0.005)
    return found


def pending(node: NodeCore) -> dict[str, int]:
    """Return the tables that are not empty and how much is in them."""
    found: dict[str, int] = {}
    for entity in node.owned():
        if isinstance(entity, ClientCore):
            found[f'{entity.full_name}: requests'] = len(entity.pending)
            if entity._port is not None:
                found |= _of_port(entity.full_name, entity._port)
        elif isinstance(entity, ActionClientCore):
            name = entity.full_name
            found[f'{name}: goals'] = len(entity.goals.active)
            for part in (entity.goal_requests, entity.result_requests, entity.cancel_requests):
                found[f'{part.full_name}: requests'] = len(part.pending)
                if part._port is not None:
                    found |= _of_port(part.full_name, part._port)
    return {name: number for name, number in found.items() if number}


def _of_port(name: str, port: ClientPort | None) -> dict[str, int]:
    tables = {
        f'{name}: {type(each).__name__}.{table}': getattr(each, table)
        for each in (port, getattr(port, '_inner', None))
        for table in _TABLES
        if isinstance(getattr(each, table, None), dict)
    }
    assert port is None or tables, f'the table of {type(port).__name__} has another name now'
    return {title: len(table) for title, table in tables.items()}
