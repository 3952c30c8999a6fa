"""The Graph view: nodes, their endpoints, and mismatches between endpoints."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from goalwire.aio.graph import EndpointKind, GraphEntity
from goalwire.apps.console.page.charts import graph_options, graph_point, mark_as_bad, rest_while_still
from goalwire.apps.console.page.parts import LiveTable, head
from goalwire.apps.console.page.view import Page, View
from goalwire.apps.console.state.graph_layout import Place, arrange
from goalwire.observe.parameters import STANDARD_SERVICES
from goalwire.security.policy import Verb

_MOST_DRAWN = 150
"""The largest number of nodes and topics in one drawing; more would be unreadable."""
_QUIET = ('/rosout', '/parameter_events')
_KINDS = {
    EndpointKind.PUBLISHER: 'publisher',
    EndpointKind.SUBSCRIPTION: 'subscription',
    EndpointKind.SERVICE: 'service',
    EndpointKind.CLIENT: 'client',
}


def qos_text(endpoint: GraphEntity) -> str:
    """Return the important policies of a QoS, in short."""
    if endpoint.kind in {EndpointKind.SERVICE, EndpointKind.CLIENT}:
        return ''
    qos = endpoint.qos
    keep = 'keep all' if qos.keeps_all else f'keep {qos.depth}'
    reliable = 'reliable' if qos.is_reliable else 'best effort'
    latched = ', transient local' if qos.is_transient_local else ''
    return f'{reliable}, {keep}{latched}'


class GraphViewPage(View):
    """Problems first, then the drawing, then every endpoint."""

    name = 'graph'
    title = 'Graph'
    icon = 'hub'
    period = 0.5

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._version = -1
        self._filter = ''
        self._chosen = ''
        self._hidden = False
        self._places: dict[str, Place] = {}

    def build(self) -> None:
        with ui.element('div').classes('gw-card flush').props('data-problems') as self._problem_card:
            head('What does not go together', 'error_outline')
            self._problems = LiveTable(
                [
                    {'name': 'name', 'label': 'Name', 'mono': True},
                    {'name': 'text', 'label': 'What is wrong', 'wrap': True},
                ],
                empty='',
            )
        with ui.element('div').classes('gw-card'):
            with head('Nodes and topics', 'hub'):
                ui.element('div').classes('gw-spread')
                ui.switch('Parameters, logs and hidden nodes', on_change=self._set_hidden).props(
                    'dense size=sm'
                ).classes('gw-small')
            self._chart = ui.echart(
                graph_options([], [], dark=self.page.is_dark), on_point_click=self._on_point
            )
            self._chart.style('height: 400px; width: 100%').props('data-chart')
            rest_while_still(self._chart)
            self._too_many = ui.label('').classes('gw-empty')
        with ui.element('div').classes('gw-card flush'):
            with head('Endpoints', 'cable'):
                ui.element('div').classes('gw-spread')
                self._search = (
                    ui.input(placeholder='Filter', on_change=self._set_filter)
                    .props('outlined dense clearable data-filter')
                    .style('width: 260px')
                )
            self._table = LiveTable(
                [
                    {'name': 'node', 'label': 'Node', 'mono': True},
                    {'name': 'kind', 'label': 'Kind'},
                    {'name': 'name', 'label': 'Name', 'mono': True},
                    {'name': 'type', 'label': 'Type', 'mono': True},
                    {'name': 'qos', 'label': 'QoS'},
                ],
                empty='Nobody is there yet. Nodes appear here as they start.',
            )

    def _set_filter(self, event: Any) -> None:
        self._filter = (event.value or '').lower()
        self._version = -1
        self.page.refresh_soon()

    def _set_hidden(self, event: Any) -> None:
        self._hidden = event.value
        self._version = -1
        self.page.refresh_soon()

    def _on_point(self, event: Any) -> None:
        name = str((event.data or {}).get('name', '')) if isinstance(event.data, dict) else ''
        self._search.set_value(name)

    def set_dark(self, dark: bool) -> None:
        del dark
        self._version = -1

    def refresh(self) -> None:
        graph = self.node.graph
        if graph.version == self._version:
            return
        self._version = graph.version
        endpoints = [
            each
            for each in graph.endpoints()
            if (self._hidden or self._is_shown(each)) and self._may_see(each)
        ]
        problems = [each for each in self.session.problems() if all(map(self._may_see, each.endpoints))]
        self._problem_card.set_visibility(bool(problems))
        self._problems.put(
            [
                {'key': f'{at} {each.name}', 'cells': [each.name, each.text], 'tone': 'bad'}
                for at, each in enumerate(problems)
            ]
        )
        bad = {endpoint.gid for problem in problems for endpoint in problem.endpoints}
        self._table.put([_row(each, bad) for each in _sort(endpoints) if self._passes(each)])
        self._draw(self._in_focus(endpoints), bad)

    def _is_shown(self, each: GraphEntity) -> bool:
        if each.node.name.startswith('_') or each.node.qualified == self.node.name:
            return False
        return each.name not in _QUIET and not each.name.endswith(STANDARD_SERVICES)

    def _may_see(self, each: GraphEntity) -> bool:
        return self.rights.may(Verb.INTROSPECT, each.node.qualified)

    def _in_focus(self, endpoints: list[GraphEntity]) -> list[GraphEntity]:
        """Return what is drawn: what passes the filter, and what lies at the other end of it."""
        if not self._filter:
            return endpoints
        names = {each.name for each in endpoints if self._passes(each)}
        return [each for each in endpoints if each.name in names]

    def _passes(self, each: GraphEntity) -> bool:
        text = f'{each.node.qualified} {each.name} {each.type_name} {_KINDS[each.kind]}'
        return self._filter in text.lower()

    def _draw(self, endpoints: list[GraphEntity], bad: set[bytes]) -> None:
        points: dict[str, dict[str, Any]] = {}
        links: dict[tuple[str, str], dict[str, Any]] = {}
        for each in endpoints:
            name = each.name.partition('/_action/')[0]
            is_action = '/_action/' in each.name
            kind = (
                'action'
                if is_action
                else 'topic'
                if each.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}
                else 'service'
            )
            node = f'n {each.node.qualified}'
            thing = f'{kind} {name}'
            points.setdefault(node, graph_point(node, each.node.qualified, 'node', dark=self.page.is_dark))
            points.setdefault(thing, graph_point(thing, name, kind, dark=self.page.is_dark))
            offers = each.kind in {EndpointKind.PUBLISHER, EndpointKind.CLIENT}
            way = (node, thing) if offers else (thing, node)
            link = links.setdefault(way, {'source': way[0], 'target': way[1]})
            if each.gid in bad:
                mark_as_bad(points[thing], link)
        drawn = len(points) <= _MOST_DRAWN
        self._chart.set_visibility(drawn)
        self._too_many.set_visibility(not drawn)
        if drawn:
            self._places = arrange(list(points), links, self._places)
            for name, point in points.items():
                point['value'] = self._places[name]
            options = graph_options(list(points.values()), list(links.values()), dark=self.page.is_dark)
            self._chart.options.clear()
            self._chart.options.update(options)
            self._chart.update()
        else:
            self._too_many.set_text(
                f'{len(points)} nodes and names: too many to draw; they are in the table below.'
            )


def _sort(endpoints: list[GraphEntity]) -> list[GraphEntity]:
    return sorted(endpoints, key=lambda each: (each.node.qualified, _KINDS[each.kind], each.name))


def _row(each: GraphEntity, bad: set[bytes]) -> dict[str, Any]:
    row: dict[str, Any] = {
        'key': f'{each.gid.hex()}{each.kind.value}{each.name}{each.node.qualified}',
        'cells': [each.node.qualified, _KINDS[each.kind], each.name, each.type_name, qos_text(each)],
    }
    if each.gid in bad:
        row['tone'] = 'bad'
    return row
