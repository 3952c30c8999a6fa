"""Statistics: the library's counts for everything that the console's node has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import ui

from goalwire.apps.console.page.parts import LiveTable, head
from goalwire.apps.console.page.view import View, duration

_QUANTILES = ('p50', 'p99')
_SUBSCRIPTION = ('received', 'taken', 'waiting', 'dropped', 'rejected')
_CLIENT = ('sent', 'answered', 'unanswered', 'given up', 'in flight', *_QUANTILES)
_PUBLISHER = ('published', 'dropped')
_SERVICE = ('received', 'answered', 'failed', 'rejected', *_QUANTILES)
"""The columns of each table: the names of the counts, with spaces, and of the latency's quantiles."""


class StatisticsView(View):
    """A table for each kind of entity."""

    name = 'statistics'
    title = 'Statistics'
    icon = 'query_stats'
    period = 1.0

    def build(self) -> None:
        with ui.element('div').classes('gw-card'):
            head(f'What {self.node.name} has counted', 'query_stats')
            ui.label(
                "The library's own statistics of this console's node: what it received, sent and lost."
            ).classes('gw-dim gw-small')
        self._subscriptions = self._card('Subscriptions', _SUBSCRIPTION, 'Nothing is subscribed to.')
        self._clients = self._card('Clients', _CLIENT, 'Nothing was called yet.')
        self._publishers = self._card('Publishers', _PUBLISHER, 'Nothing is published.')
        self._services = self._card('Services', _SERVICE, 'No services.')

    def _card(self, title: str, columns: Sequence[str], empty: str) -> LiveTable:
        with ui.element('div').classes('gw-card flush'):
            head(title)
            return LiveTable(
                [
                    {'name': 'name', 'label': 'Name', 'mono': True},
                    *({'name': each, 'label': each, 'align': 'right', 'width': '92px'} for each in columns),
                ],
                empty=empty,
            )

    def refresh(self) -> None:
        counted = self.node.statistics()
        for table, entities, names in (
            (self._subscriptions, counted.subscriptions, _SUBSCRIPTION),
            (self._clients, counted.clients, _CLIENT),
            (self._publishers, counted.publishers, _PUBLISHER),
            (self._services, counted.services, _SERVICE),
        ):
            table.put([_row(at, each, names) for at, each in enumerate(entities)])


def _row(at: int, counted: Any, names: Sequence[str]) -> dict[str, Any]:
    cells = [_cell(counted, name) for name in names]
    return {'key': f'{at} {counted.name}', 'cells': [counted.name, *cells]}


def _cell(counted: Any, name: str) -> Any:
    if name in _QUANTILES:
        return duration(getattr(counted.latency, name)) if counted.latency.count else ''
    return getattr(counted, name.replace(' ', '_'))
