"""Statistics: the library's counts for everything that the console's node has."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from goalwire.apps.console.page.parts import LiveTable, head
from goalwire.apps.console.page.view import View, duration


class StatisticsView(View):
    """A table for each kind of entity."""

    name = 'statistics'
    title = 'Statistics'
    icon = 'query_stats'
    period = 1.0

    def build(self) -> None:
        with ui.element('div').classes('gw-card'):
            with ui.element('div').classes('gw-head'):
                head(f'What {self.node.name} has counted', 'query_stats')
            ui.label(
                "The library's own statistics of this console's node: what it received, sent and lost."
            ).classes('gw-dim gw-small')
        self._subscriptions = self._card(
            'Subscriptions',
            ['received', 'taken', 'waiting', 'dropped', 'rejected'],
            'Nothing is subscribed to.',
        )
        self._clients = self._card(
            'Clients',
            ['sent', 'answered', 'unanswered', 'given up', 'in flight', 'p50', 'p99'],
            'Nothing was called yet.',
        )
        self._publishers = self._card('Publishers', ['published', 'dropped'], 'Nothing is published.')
        self._services = self._card(
            'Services', ['received', 'answered', 'failed', 'rejected', 'p50', 'p99'], 'No services.'
        )

    def _card(self, title: str, columns: list[str], empty: str) -> LiveTable:
        with ui.element('div').classes('gw-card flush'):
            with ui.element('div').classes('gw-head'):
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
        self._subscriptions.put(
            [
                _row(at, each.name, each.received, each.taken, each.waiting, each.dropped, each.rejected)
                for at, each in enumerate(counted.subscriptions)
            ]
        )
        self._clients.put(
            [
                _row(
                    at,
                    each.name,
                    each.sent,
                    each.answered,
                    each.unanswered,
                    each.given_up,
                    each.in_flight,
                    *_quantiles(each.latency),
                )
                for at, each in enumerate(counted.clients)
            ]
        )
        self._publishers.put(
            [_row(at, each.name, each.published, each.dropped) for at, each in enumerate(counted.publishers)]
        )
        self._services.put(
            [
                _row(
                    at,
                    each.name,
                    each.received,
                    each.answered,
                    each.failed,
                    each.rejected,
                    *_quantiles(each.latency),
                )
                for at, each in enumerate(counted.services)
            ]
        )


def _quantiles(latency: Any) -> list[str]:
    return [duration(latency.p50), duration(latency.p99)] if latency.count else ['', '']


def _row(at: int, name: str, *cells: Any) -> dict[str, Any]:
    return {'key': f'{at} {name}', 'cells': [name, *cells]}
