"""Graph: who is there, what each offers and uses, and what does not go together."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from goalwire.aio.graph import EndpointKind, GraphEntity
from goalwire.apps.console.graph_layout import Place, arranged
from goalwire.apps.console.page.parts import LiveTable, head
from goalwire.apps.console.page.view import View

_MOST_DRAWN = 150
"""Nodes and topics that a drawing shows; with more, nobody could read it."""
_QUIET = ('/rosout', '/parameter_events')
_KINDS = {
    EndpointKind.PUBLISHER: 'publisher',
    EndpointKind.SUBSCRIPTION: 'subscription',
    EndpointKind.SERVICE: 'service',
    EndpointKind.CLIENT: 'client',
}
PARAMETER_SERVICES = (
    '/describe_parameters',
    '/get_parameter_types',
    '/get_parameters',
    '/list_parameters',
    '/set_parameters',
    '/set_parameters_atomically',
    '/get_type_description',
)


def qos_text(endpoint: GraphEntity) -> str:
    """Return what matters of a QoS, in short."""
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

    def build(self) -> None:
        self._version = -1
        self._filter = ''
        self._chosen = ''
        self._hidden = False
        self._places: dict[str, Place] = {}
        with ui.element('div').classes('gw-card flush').props('data-problems') as self._problem_card:
            with ui.element('div').classes('gw-head'):
                head('What does not go together', 'error_outline')
            self._problems = LiveTable(
                [
                    {'name': 'name', 'label': 'Name', 'mono': True},
                    {'name': 'text', 'label': 'What is wrong', 'wrap': True},
                ],
                empty='',
            )
        with ui.element('div').classes('gw-card'):
            with ui.element('div').classes('gw-head'):
                head('Nodes and topics', 'hub')
                ui.element('div').classes('gw-spread')
                ui.switch('Parameters, logs and hidden nodes', on_change=self._set_hidden).props(
                    'dense size=sm'
                ).classes('gw-small')
            self._chart = ui.echart(
                _chart_options([], [], dark=self.page.is_dark), on_point_click=self._on_point
            )
            self._chart.style('height: 400px; width: 100%').props('data-chart')
            self._too_many = ui.label('').classes('gw-empty')
        with ui.element('div').classes('gw-card flush'):
            with ui.element('div').classes('gw-head'):
                head('Endpoints', 'cable')
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
        endpoints = [each for each in graph.endpoints() if self._hidden or self._is_shown(each)]
        problems = self.session.problems()
        self._problem_card.set_visibility(bool(problems))
        self._problems.put(
            [
                {'key': f'{at} {each.name}', 'cells': [each.name, each.text], 'tone': 'bad'}
                for at, each in enumerate(problems)
            ]
        )
        bad = {endpoint.gid for problem in problems for endpoint in problem.endpoints}
        self._table.put([_row(each, bad) for each in _sorted(endpoints) if self._passes(each)])
        self._draw(endpoints, bad)

    def _is_shown(self, each: GraphEntity) -> bool:
        if each.node.name.startswith('_') or each.node.qualified == self.node.name:
            return False
        return each.name not in _QUIET and not each.name.endswith(PARAMETER_SERVICES)

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
            points.setdefault(node, _point(node, each.node.qualified, 'node', dark=self.page.is_dark))
            points.setdefault(thing, _point(thing, name, kind, dark=self.page.is_dark))
            offers = each.kind in {EndpointKind.PUBLISHER, EndpointKind.CLIENT}
            way = (node, thing) if offers else (thing, node)
            link = links.setdefault(way, {'source': way[0], 'target': way[1]})
            if each.gid in bad:
                link['lineStyle'] = {'color': '#ef4444', 'width': 2.5}
                points[thing]['itemStyle'] = {'color': '#ef4444'}
        drawn = len(points) <= _MOST_DRAWN
        self._chart.set_visibility(drawn)
        self._too_many.set_visibility(not drawn)
        if drawn:
            self._places = arranged(list(points), links, self._places)
            for name, point in points.items():
                point['x'], point['y'] = self._places[name]
            options = _chart_options(list(points.values()), list(links.values()), dark=self.page.is_dark)
            self._chart.options.clear()
            self._chart.options.update(options)
            self._chart.update()
        else:
            self._too_many.set_text(
                f'{len(points)} nodes and names: too many to draw; they are in the table below.'
            )


def _sorted(endpoints: list[GraphEntity]) -> list[GraphEntity]:
    return sorted(endpoints, key=lambda each: (each.node.qualified, _KINDS[each.kind], each.name))


def _row(each: GraphEntity, bad: set[bytes]) -> dict[str, Any]:
    row: dict[str, Any] = {
        'key': f'{each.gid.hex()}{each.kind.value}{each.name}{each.node.qualified}',
        'cells': [each.node.qualified, _KINDS[each.kind], each.name, each.type_name, qos_text(each)],
    }
    if each.gid in bad:
        row['tone'] = 'bad'
    return row


_COLOURS = {'node': '#6366f1', 'topic': '#94a3b8', 'service': '#14b8a6', 'action': '#f59e0b'}
_SHAPES = {'node': 'circle', 'topic': 'roundRect', 'service': 'diamond', 'action': 'triangle'}


def _point(key: str, name: str, kind: str, *, dark: bool) -> dict[str, Any]:
    return {
        'id': key,
        'name': name,
        'category': kind,
        'symbol': _SHAPES[kind],
        'symbolSize': 22 if kind == 'node' else 13,
        'itemStyle': {'color': _COLOURS[kind]},
        'label': {
            'fontWeight': 600 if kind == 'node' else 400,
            'color': ('#e6ebf4' if dark else '#0f172a')
            if kind == 'node'
            else ('#93a1b8' if dark else '#64748b'),
        },
    }


def _chart_options(
    points: list[dict[str, Any]], links: list[dict[str, Any]], *, dark: bool
) -> dict[str, Any]:
    return {
        'animation': False,
        'backgroundColor': 'transparent',
        'tooltip': {'renderMode': 'richText'},
        'legend': [
            {
                'data': [
                    {'name': kind, 'icon': _SHAPES[kind], 'itemStyle': {'color': _COLOURS[kind]}}
                    for kind in _COLOURS
                ],
                'top': 0,
                'left': 0,
                'textStyle': {'color': '#93a1b8' if dark else '#64748b'},
                'itemHeight': 10,
            }
        ],
        'series': [
            {
                'type': 'graph',
                'layout': 'none',
                'left': 90,
                'right': 90,
                'top': 44,
                'bottom': 34,
                'roam': True,
                'draggable': True,
                'labelLayout': {'hideOverlap': True},
                'label': {'show': True, 'position': 'bottom', 'fontSize': 11, 'formatter': '{b}'},
                'edgeSymbol': ['none', 'arrow'],
                'edgeSymbolSize': 6,
                'lineStyle': {'color': '#475569' if dark else '#cbd5e1', 'width': 1.2, 'curveness': 0.06},
                'emphasis': {'focus': 'adjacency'},
                'categories': [{'name': kind} for kind in _COLOURS],
                'data': points,
                'links': links,
            }
        ],
    }
