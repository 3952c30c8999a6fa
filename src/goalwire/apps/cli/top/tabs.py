"""The tabs of `top`: for each its rows, the subscriptions for the rows, and the details of a row."""

from __future__ import annotations

from time import monotonic, time
from typing import TYPE_CHECKING, ClassVar, NamedTuple, TypeAlias

from rich.text import Text
from textual.widgets import DataTable, RichLog, TabPane

from goalwire.apps.cli.commands.action.display import bar
from goalwire.apps.cli.commands.action.watch import ENDED_SHOWN
from goalwire.apps.cli.commands.node import sections
from goalwire.apps.cli.commands.service.call import histogram_lines
from goalwire.apps.cli.framework.output import STATUS_STYLES, escape, spell_out
from goalwire.apps.cli.top.data import (
    Goals,
    Log,
    ServiceLatencies,
    TopicRates,
    one_line,
)
from goalwire.graph.names import SEND_GOAL, NamesAndTypes, without_hidden
from goalwire.observe.goals import Goal
from goalwire.observe.latencies import show_seconds
from goalwire.observe.log import LogLine
from goalwire.observe.parameters import STANDARD_SERVICES
from goalwire.observe.service_calls import POSTFIX
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Collection

    from textual.app import ComposeResult

    from goalwire.graph.graph import Graph

Rows: TypeAlias = 'dict[str, list[Text]]'
_LEVEL_STYLES = {'WARN': 'yellow', 'ERROR': 'red', 'FATAL': 'bold red'}


def cell(text: str, style: str = '') -> Text:
    """Return a peer's text as one line without control characters."""
    return Text(spell_out(text), style, no_wrap=True)


class View(NamedTuple):
    """The user's choice of rows and order."""

    own: str = ''
    """The node of `top` itself, which is not counted."""
    hidden: bool = False
    """True to show names that begin with an underscore, and the services that every node has."""
    filter: str = ''

    def names(self, found: NamesAndTypes) -> NamesAndTypes:
        """Return the names that are to be shown."""
        shown = found if self.hidden else without_hidden(found)
        return [(name, types) for name, types in shown if self.filter in name]

    def nodes(self, graph: Graph) -> dict[str, int]:
        """Return the names of the nodes, and how many nodes share each name."""
        numbers: dict[str, int] = {}
        for entity in graph.nodes():
            numbers[entity.node.qualified] = numbers.get(entity.node.qualified, 0) + 1
        numbers.pop(self.own, None)
        return {name: numbers[name] for name, _ in self.names([(name, []) for name in sorted(numbers)])}

    def services(self, graph: Graph) -> NamesAndTypes:
        """Return the services, without those that every node has."""
        found = self.names(graph.service_names_and_types())
        return found if self.hidden else [each for each in found if not each[0].endswith(STANDARD_SERVICES)]

    def topics(self, graph: Graph) -> NamesAndTypes:
        """Return the topics."""
        return self.names(graph.topic_names_and_types())

    def actions(self, graph: Graph) -> NamesAndTypes:
        """Return the actions."""
        return self.names(graph.action_names_and_types())

    def summary(self, graph: Graph) -> str:
        """Return the numbers of nodes, topics and so on, in one line."""
        counts = (
            f'{sum(self.nodes(graph).values())} nodes',
            f'{len(self.topics(graph))} topics',
            f'{len(self.services(graph))} services',
            f'{len(self.actions(graph))} actions',
        )
        return ', '.join(counts) + (f'  filter: {self.filter}' if self.filter else '')

    def endpoints(self, graph: Graph, kind: EndpointKind, name: str) -> int:
        """Return how many endpoints a name has, without those of `top`."""
        return sum(entity.node.qualified != self.own for entity in graph.entities(kind, name))


class TableTab(TabPane):
    """A tab that is a table, of which one row is chosen."""

    COLUMNS: ClassVar[tuple[str, ...]] = ()

    def __init__(self, title: str, name: str) -> None:
        super().__init__(title, id=name)
        self._rows: Rows = {}

    def compose(self) -> ComposeResult:
        """Lay out the tab."""
        yield DataTable(cursor_type='row', zebra_stripes=True)

    @property
    def table(self) -> DataTable[Text]:
        """The table of the tab."""
        return self.query_one(DataTable)

    def on_mount(self) -> None:
        """Name the columns."""
        for title in self.COLUMNS:
            self.table.add_column(title, key=title)

    @property
    def chosen(self) -> str | None:
        """The key of the row under the cursor."""
        keys = list(self._rows)
        at = self.table.cursor_row
        return keys[at] if 0 <= at < len(keys) else None

    def show(self, rows: Rows) -> None:
        """Draw rows; the cursor stays with its row."""
        table = self.table
        if list(rows) != list(self._rows):
            chosen, at, offset = self.chosen, table.cursor_row, table.scroll_offset
            table.clear()
            self._widen(rows, self.COLUMNS)
            for key, cells in rows.items():
                table.add_row(*cells, key=key)
            at = list(rows).index(chosen) if chosen in rows else min(at, len(rows) - 1)
            table.move_cursor(row=at, scroll=False)
            table.scroll_to(y=offset.y, animate=False)
        else:
            changed = [
                (key, title, new)
                for key, cells in rows.items()
                for title, old, new in zip(self.COLUMNS, self._rows[key], cells, strict=True)
                if old != new
            ]
            self._widen(rows, {title for _, title, _ in changed})
            for key, title, new in changed:
                table.update_cell(key, title, new, update_width=True)
        self._rows = rows

    def _widen(self, rows: Rows, titles: Collection[str]) -> None:
        """Make columns wide enough for their next content.

        The table itself widens them only when it is idle; until then a longer text would be drawn cut off.
        """
        for number, column in enumerate(self.table.ordered_columns):
            if column.key.value in titles:
                widths = [cells[number].cell_len for cells in rows.values()]
                column.content_width = max([column.content_width, *widths])

    def on_screen(self) -> list[str]:
        """Return the keys of the rows that can be seen."""
        first = round(self.table.scroll_offset.y)
        return list(self._rows)[first : first + max(1, self.table.size.height)]

    def refresh_rows(self, graph: Graph, view: View) -> None:
        """Draw the present data, and listen for the rows on the screen."""
        raise NotImplementedError

    def quiet(self) -> None:
        """End the tab's subscriptions, because it is hidden."""

    def details(self, graph: Graph) -> str:
        """Return the details of the chosen row."""
        raise NotImplementedError


class NodesTab(TableTab):
    """Nodes, with the numbers of their endpoints."""

    COLUMNS = ('node', 'publishers', 'subscriptions', 'services', 'clients', 'actions')
    _KINDS = (EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION, EndpointKind.SERVICE, EndpointKind.CLIENT)

    def refresh_rows(self, graph: Graph, view: View) -> None:
        """Draw the present data."""
        rows: Rows = {}
        for name, number in view.nodes(graph).items():
            namespace, _, base = name.rpartition('/')
            node = base, namespace or '/'
            counts = [len(without_hidden(graph.names_and_types_by_node(kind, *node))) for kind in self._KINDS]
            counts.append(len(graph.action_servers_by_node(*node)))
            title = name if number == 1 else f'{name} ({number} of that name)'
            rows[name] = [cell(title), *(Text(str(count), justify='right') for count in counts)]
        self.show(rows)

    def details(self, graph: Graph) -> str:
        """Return the output of `ros2 node info`."""
        if self.chosen is None:
            return ''
        lines = [self.chosen]
        for title, found in sections(graph, self.chosen, include_hidden=False):
            lines.append(f'  {title}:')
            lines += [f'    {name}: {", ".join(types)}' for name, types in found]
        return '\n'.join(map(spell_out, lines))


class TopicsTab(TableTab):
    """Topics, with the rates of their messages."""

    COLUMNS = ('topic', 'Hz', 'bytes/s', 'publishers', 'subscriptions', 'type', 'note')

    def __init__(self, title: str, name: str, rates: TopicRates) -> None:
        super().__init__(title, name)
        self._rates = rates

    def refresh_rows(self, graph: Graph, view: View) -> None:
        """Draw the present data, and measure the topics on the screen that have a publisher."""
        now = monotonic()
        rows: Rows = {}
        types: dict[str, str] = {}
        for name, kinds in view.topics(graph):
            publishers = view.endpoints(graph, EndpointKind.PUBLISHER, name)
            rate = self._rates.rates.get(name)
            pace = rate.pace(now) if rate is not None else None
            hz, size = ('', '') if pace is None else (f'{pace.messages:.4g}', _size(pace.bytes))
            if publishers:
                types[name] = kinds[0]
            note = self._rates.readers.problems.get(name, '')
            if rate is not None and rate.is_paused:
                note = 'much: measured for a moment; m measures on'
            counts = str(publishers), str(view.endpoints(graph, EndpointKind.SUBSCRIPTION, name))
            numbers = (Text(text, justify='right') for text in (hz, size, *counts))
            rows[name] = [cell(name), *numbers, cell(', '.join(kinds)), cell(note, 'dim')]
        self.show(rows)
        self._rates.watch({name: types[name] for name in self.on_screen() if name in types})

    def quiet(self) -> None:
        """Stop measuring."""
        self._rates.watch({})

    def measure(self) -> None:
        """Measure the chosen topic even if its data rate is high."""
        if self.chosen is not None:
            self._rates.ask(self.chosen)
            self._rates.readers.again(self.chosen)


class ServicesTab(TableTab):
    """Services, with their latencies: of the calls of `top`, or of all calls if introspection is on."""

    COLUMNS = ('service', 'servers', 'clients', 'calls', 'p50', 'p99', 'max', 'failed', 'of', 'type')

    def __init__(self, title: str, name: str, latencies: ServiceLatencies) -> None:
        super().__init__(title, name)
        self._latencies = latencies

    def refresh_rows(self, graph: Graph, view: View) -> None:
        """Draw the present data, and listen to the events of the services on the screen."""
        rows: Rows = {}
        types: dict[str, str] = {}
        for name, kinds in view.services(graph):
            types[name] = kinds[0]
            counts = [
                str(view.endpoints(graph, kind, name)) for kind in (EndpointKind.SERVICE, EndpointKind.CLIENT)
            ]
            numbers = (Text(text, justify='right') for text in [*counts, *self._figures(name)])
            rows[name] = [cell(name), *numbers, cell(', '.join(kinds))]
        self.show(rows)
        self._latencies.watch(
            {
                name: types[name]
                for name in self.on_screen()
                if graph.count(EndpointKind.PUBLISHER, name + POSTFIX)
            }
        )

    def _figures(self, name: str) -> list[str]:
        best = self._latencies.best(name)
        if best is None:
            return [''] * 6
        whose, latencies = best
        times = [latencies.percentile(share) for share in (0.5, 0.99, 1.0)] if latencies.number else []
        shown = [show_seconds(each) for each in times] or ['', '', '']
        return [str(latencies.number), *shown, str(latencies.failed or ''), whose]

    def quiet(self) -> None:
        """Stop listening."""
        self._latencies.watch({})

    def details(self, graph: Graph) -> str:
        """Return the servers and clients, and a histogram."""
        if self.chosen is None:
            return ''
        lines = [spell_out(self.chosen)]
        for title, kind in (('servers', EndpointKind.SERVICE), ('clients', EndpointKind.CLIENT)):
            lines.append(f'  {title}:')
            lines += [f'    {spell_out(each.node.qualified)}' for each in graph.entities(kind, self.chosen)]
        best = self._latencies.best(self.chosen)
        if best is not None and best[1].number:
            lines += [f'  latencies, as {best[0]} {"sees" if best[0] == "top" else "tell"}:']
            lines += histogram_lines(best[1])
        return '\n'.join(lines)


class GoalsTab(TableTab):
    """Actions, and below each its goals."""

    COLUMNS = ('action / goal', 'status', 'age', 'progress', 'feedback')

    def __init__(self, title: str, name: str, goals: Goals) -> None:
        super().__init__(title, name)
        self._goals = goals
        self.types: dict[str, str] = {}

    def refresh_rows(self, graph: Graph, view: View) -> None:
        """Draw the present data, and follow the goals of the actions on the screen."""
        rows: Rows = {}
        found = view.actions(graph)
        self.types = {name: kinds[0] for name, kinds in found}
        for name, kinds in found:
            servers = graph.count(EndpointKind.SERVICE, name + SEND_GOAL)
            note = self._goals.readers.problems.get(name) or f'[{", ".join(kinds)}]'
            served = '' if servers == 1 else f'{servers} servers'
            rows[name] = [cell(name, 'bold'), cell(served), Text(), Text(), cell(note, 'dim')]
            for goal in self._goals.table.list_reported(name, ENDED_SHOWN):
                rows[f'{name} {goal.goal_id}'] = _goal_row(goal)
        self.show(rows)
        names = {key.partition(' ')[0] for key in self.on_screen()}
        self._goals.watch({name: kind for name, kind in self.types.items() if name in names})

    @property
    def chosen_action(self) -> tuple[str, str | None] | None:
        """The action of the chosen row, and the goal if the row shows a goal."""
        if self.chosen is None:
            return None
        name, _, goal_id = self.chosen.partition(' ')
        return name, goal_id or None

    def quiet(self) -> None:
        """Stop following goals."""
        self._goals.watch({})

    def details(self, graph: Graph) -> str:
        """Return all of a goal's feedback, or the servers of an action."""
        if self.chosen_action is None:
            return ''
        name, goal_id = self.chosen_action
        goal = self._goals.table.get(name, goal_id) if goal_id is not None else None
        if goal is not None:
            from rosidl_runtime_py import message_to_yaml

            feedback = goal.feedback
            told = 'no feedback yet' if feedback is None else message_to_yaml(feedback, truncate_length=128)
            return f'the goal {goal_id} of {spell_out(name)}\n{escape(told)}'
        servers = graph.entities(EndpointKind.SERVICE, name + SEND_GOAL)
        return '\n'.join(
            [f'{spell_out(name)} [{spell_out(self.types.get(name, ""))}]', '  servers:']
            + [f'    {spell_out(each.node.qualified)}' for each in servers]
        )


class LogTab(TabPane):
    """The lines of /rosout."""

    def __init__(self, title: str, name: str) -> None:
        super().__init__(title, id=name)
        self._drawn: tuple[str, int] = '', 0
        self._drawn_version = 0

    def compose(self) -> ComposeResult:
        """Lay out the tab."""
        yield RichLog(max_lines=1000, wrap=True, markup=False, highlight=False)

    def refresh_lines(self, log: Log, view: View) -> None:
        """Show the new lines that pass the filter, or all lines if the filter or the width has changed."""
        shown = self.query_one(RichLog)
        if not shown.size.width:
            return  # the table is not laid out yet
        if self._drawn != (view.filter, shown.size.width):
            self._drawn = view.filter, shown.size.width
            self._drawn_version = 0
            shown.clear()
        for line in log.book.since(self._drawn_version, view.filter):
            shown.write(_log_text(line), width=shown.size.width - 2)
        self._drawn_version = log.book.version


def _log_text(line: LogLine) -> Text:
    text = f'[{line.level_name}] [{line.stamp:.3f}] [{spell_out(line.node)}]: {escape(line.text)}'
    return Text(text, _LEVEL_STYLES.get(line.level_name, ''))


def _size(bytes_a_second: float) -> str:
    for unit in ('B', 'KB', 'MB'):
        if bytes_a_second < 1000:
            return f'{bytes_a_second:.3g} {unit}'
        bytes_a_second /= 1000
    return f'{bytes_a_second:.3g} GB'


def _goal_row(goal: Goal) -> list[Text]:
    age = f'{max(0.0, time() - (goal.accepted or 0.0)):.1f} s' if goal.is_active else ''
    return [
        Text(f'  {goal.goal_id[:8]}'),
        Text(goal.status, STATUS_STYLES.get(goal.status, '')),
        Text(age, justify='right'),
        Text('' if goal.progress is None else bar(goal.progress)),
        cell('' if goal.feedback is None else one_line(goal.feedback)[:200]),
    ]
