"""The screen of `top`: tabs, a pane for details, and keys. Its data comes from data.py."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, ClassVar

from rich.text import Text
from textual.app import App
from textual.binding import Binding
from textual.containers import VerticalScroll
from textual.css.query import NoMatches
from textual.widgets import Footer, Input, Static, TabbedContent

import goalwire
from goalwire.apps.cli.framework.failures import explain_error
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import escape, spell_out
from goalwire.apps.cli.top.data import Echo, Goals, Log, ServiceLatencies, TopicRates
from goalwire.apps.cli.top.dialogs import Confirmation, Form
from goalwire.apps.cli.top.requests import Call, Cancel, Request, SendGoal
from goalwire.apps.cli.top.tabs import GoalsTab, LogTab, NodesTab, ServicesTab, TableTab, TopicsTab, View

if TYPE_CHECKING:
    from collections.abc import Coroutine
    from typing import Any

    from textual.app import ComposeResult
    from textual.binding import BindingType

    from goalwire.graph.graph import Graph

REPAINT_S = 0.5
_TAB_OF = {'echo': 'topics', 'measure': 'topics', 'call': 'services', 'send_goal': 'goals', 'cancel': 'goals'}
"""The tab that an action belongs to."""


class Options:
    """The options of the command line."""

    def __init__(self, *, hidden: bool = False, progress: str | None = None, timeout: float = 10.0) -> None:
        """`timeout` limits a call, and the wait until a goal is accepted, in s."""
        self.hidden = hidden
        self.progress = progress
        self.timeout = timeout


class Top(App[Outcome]):
    """Nodes, topics, services, goals and log lines of the robots that a node sees."""

    ENABLE_COMMAND_PALETTE = False
    CSS = """
    #head { height: 1; background: $primary; color: $text; padding: 0 1; }
    TabbedContent { height: 1fr; }
    TabPane { padding: 0; }
    DataTable { height: 1fr; }
    RichLog { height: 1fr; }
    #details { height: 40%; border-top: solid $accent; padding: 0 1; display: none; }
    #filter { display: none; height: 1; border: none; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('1', 'tab("nodes")', 'Nodes', show=False),
        Binding('2', 'tab("topics")', 'Topics', show=False),
        Binding('3', 'tab("services")', 'Services', show=False),
        Binding('4', 'tab("goals")', 'Goals', show=False),
        Binding('5', 'tab("log")', 'Log', show=False),
        Binding('e', 'echo', 'Echo'),
        Binding('m', 'measure', 'Measure on'),
        Binding('c', 'call', 'Call'),
        Binding('g', 'send_goal', 'Send a goal'),
        Binding('x', 'cancel(False)', 'Cancel the goal'),
        Binding('X', 'cancel(True)', 'Cancel all'),
        Binding('i', 'details', 'Details'),
        Binding('slash', 'filter', 'Filter'),
        Binding('h', 'hidden', 'Hidden names'),
        Binding('escape', 'close', 'Close', show=False),
        Binding('q', 'leave', 'Quit'),
        Binding('ctrl+q', 'leave', show=False, priority=True),
        Binding('ctrl+c', 'interrupt', show=False, priority=True),
    ]

    def __init__(self, node: goalwire.Node, options: Options) -> None:
        super().__init__()
        self._node = node
        self._options = options
        self._view = View(own=node.name, hidden=options.hidden)
        self._rates = TopicRates(node)
        self._latencies = ServiceLatencies(node)
        self._goals = Goals(node, options.progress)
        self._echo = Echo(node, self._show_echo)
        self._log_lines = Log(node)
        self._echoed = ''
        self._tasks: set[asyncio.Task[None]] = set()
        self.own_goals: dict[str, str] = {}
        """By goal id: the actions of goals that `top` has sent and that have not ended."""
        self.fault: Exception | None = None
        """The unexpected error that has ended this program."""

    # -- start and end of the screen -----------------------------------------------------------------------

    def compose(self) -> ComposeResult:
        """Lay out the screen."""
        yield Static(id='head')
        with TabbedContent(initial='nodes'):
            yield NodesTab('1 Nodes', 'nodes')
            yield TopicsTab('2 Topics', 'topics', self._rates)
            yield ServicesTab('3 Services', 'services', self._latencies)
            yield GoalsTab('4 Goals', 'goals', self._goals)
            yield LogTab('5 Log', 'log')
        with VerticalScroll(id='details'):
            yield Static(id='text')
        yield Input(placeholder='show names with…', id='filter')
        yield Footer()

    def on_mount(self) -> None:
        """Begin to refresh."""
        self._focus_tab()
        self.set_interval(REPAINT_S, self.repaint)
        self.call_after_refresh(self.repaint)

    def repaint(self) -> None:
        """Draw the present data."""
        with suppress(NoMatches):  # A timer may fire while the screen is being closed.
            self._repaint()

    def _repaint(self) -> None:
        graph = self._graph
        self.query_one('#head', Static).update(Text(spell_out(f'goalwire top  {self._view.summary(graph)}')))
        tab = self._tab
        if isinstance(tab, TableTab):
            tab.refresh_rows(graph, self._view)
        elif isinstance(tab, LogTab):
            tab.refresh_lines(self._log_lines, self._view)

    async def close_data(self) -> None:
        """End all subscriptions, and cancel running requests."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for data in (self._rates, self._latencies, self._goals, self._echo, self._log_lines):
            await data.readers.close()

    def _handle_exception(self, error: Exception) -> None:
        """End with the error, which `top` then prints in one line; Textual would print a long traceback."""
        self.fault = self.fault or error
        self.exit(Outcome.FAILED)

    @property
    def _graph(self) -> Graph:
        return self._node.context.graph

    @property
    def _tab(self) -> TableTab | LogTab:
        name = self.query_one(TabbedContent).active
        tab = self.query_one(f'#{name}')
        assert isinstance(tab, TableTab | LogTab)
        return tab

    # -- tabs and details ----------------------------------------------------------------------------------

    def say(self, text: str, style: str = '') -> None:
        """Show a text in the pane of details."""
        with suppress(NoMatches):  # An answer may come while the screen is being closed.
            self.query_one('#text', Static).update(Text(escape(text), style))
            self.query_one('#details').display = True

    def _show_echo(self, text: str) -> None:
        self.say(f'{spell_out(self._echoed)}\n{text}')

    def on_tabbed_content_tab_activated(self) -> None:
        """Show a tab that the mouse has chosen."""
        self._show_tab()

    def _show_tab(self) -> None:
        """Listen for the shown tab, and stop listening for the others."""
        for tab in self.query(TableTab):
            if tab is not self._tab:
                tab.quiet()
        self._focus_tab()
        self.refresh_bindings()
        self.repaint()

    def _focus_tab(self) -> None:
        tab = self._tab
        (tab.table if isinstance(tab, TableTab) else tab.query_one('RichLog')).focus()

    def on_data_table_row_selected(self) -> None:
        """When the user presses Enter on a row, echo the row's topic, or show details of any other row."""
        if self._tab.id == 'topics':
            self.action_echo()
        else:
            self.action_details()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Return whether a key is offered: each works only on its own tab."""
        del parameters
        if action in {'filter', 'leave'}:
            return True
        tab: str = self.query_one(TabbedContent).active
        if action in {'details', 'hidden'}:
            return tab not in {'log', 'topics' if action == 'details' else ''}
        return _TAB_OF.get(action, tab) == tab

    # -- keys ----------------------------------------------------------------------------------------------

    def action_tab(self, name: str) -> None:
        """Show another tab, which then gets the keys."""
        self.query_one(TabbedContent).active = name
        self._show_tab()

    def action_details(self) -> None:
        """Show the details of the chosen row."""
        tab = self._tab
        if isinstance(tab, TableTab) and (text := tab.details(self._graph)):
            self._echo.stop()
            self.say(text)

    def action_echo(self) -> None:
        """Show the messages of the chosen topic as they come."""
        tab = self.query_one(TopicsTab)
        types = dict(self._graph.topic_names_and_types())
        if tab.chosen in types:
            self._echoed = tab.chosen
            self.say(f'{spell_out(self._echoed)}\nno message yet')
            self._echo.follow(tab.chosen, types[tab.chosen][0])

    def action_measure(self) -> None:
        """Measure the chosen topic even if its data rate is high."""
        self.query_one(TopicsTab).measure()

    def action_call(self) -> None:
        """Call the chosen service."""
        name = self.query_one(ServicesTab).chosen
        types = dict(self._graph.service_names_and_types())
        if name in types:
            kind, timeout = types[name][0], self._options.timeout
            self._begin(lambda: Call(self._node, name, kind, self._latencies, timeout))

    def action_send_goal(self) -> None:
        """Send a goal to the chosen action."""
        tab = self.query_one(GoalsTab)
        if tab.chosen_action is not None:
            name = tab.chosen_action[0]
            self._begin(
                lambda: SendGoal(self._node, name, tab.types[name], self.own_goals, self._options.timeout)
            )

    def action_cancel(self, all_goals: bool) -> None:
        """Cancel the chosen goal, or all goals of the chosen action."""
        chosen = self.query_one(GoalsTab).chosen_action
        if chosen is None:
            return
        name, goal_id = chosen
        if goal_id is None and not all_goals:
            self.say('choose one of its goals, or X to cancel all of them')
            return
        self._begin(lambda: Cancel(self._node, name, None if all_goals else goal_id, self._options.timeout))

    def action_hidden(self) -> None:
        """Show or hide names that begin with an underscore."""
        self._view = self._view._replace(hidden=not self._view.hidden)
        self.repaint()

    def action_filter(self) -> None:
        """Ask for a part of the names that are to be shown."""
        field = self.query_one('#filter', Input)
        field.display = True
        field.focus()

    def on_input_changed(self, event: Input.Changed) -> None:
        """Show the rows that fit the filter."""
        self._view = self._view._replace(filter=event.value)
        self.repaint()

    def on_input_submitted(self) -> None:
        """Keep the filter."""
        self.query_one('#filter').display = False
        self._focus_tab()

    def action_close(self) -> None:
        """Close the filter, or the pane of details."""
        field = self.query_one('#filter', Input)
        if field.display:
            field.value = ''
            self.on_input_submitted()
            return
        self._echo.stop()
        self.query_one('#details').display = False

    def action_leave(self) -> None:
        """Close `top`; if goals that it has sent still run, ask whether to cancel them."""
        if not self.own_goals:
            self.exit(Outcome.OK)
            return
        self.run_worker(self._ask_before_leaving())

    def action_interrupt(self) -> None:
        """Close `top` at once, as Ctrl-C ends other commands."""
        self.exit(Outcome.INTERRUPTED)

    # -- sending -------------------------------------------------------------------------------------------

    def _begin(self, make: Any) -> None:
        self.run_worker(self._prepare(make), exclusive=True, group='request')

    async def _prepare(self, make: Any) -> None:
        """Let the user fill in and confirm a request, then send it."""
        try:
            request: Request = make()
        except Exception as error:
            self.say(explain_error(error)[1], 'red')
            return
        text = request.template()
        while True:
            if text is None:
                message = request.read('')
            else:
                filled = await self.push_screen_wait(Form(request, text))
                if filled is None:
                    return
                text, message = filled
            title = f'{request.title}  [{request.type_name}]'
            if await self.push_screen_wait(Confirmation(title, request.show(message))):
                break
            if text is None:
                return
        self._start(self._send(request, message))

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _send(self, request: Request, message: Any) -> None:
        self._echo.stop()
        self.say(f'{request.title} …')
        try:
            await request.send(message, self.say)
        except Exception as error:
            self.say(explain_error(error)[1], 'red')

    async def _ask_before_leaving(self) -> None:
        goals = dict(self.own_goals)
        title = 'goals that were sent from here go on'
        what = '\n'.join(f'{goal_id} of {name}' for goal_id, name in goals.items())
        if await self.push_screen_wait(Confirmation(title, what, 'q', 'leaves without them')):
            self.exit(Outcome.OK)
