"""goalwire top, part by part: what is shown, what is listened to, and what it takes to send something."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from typing import Any, NamedTuple

import pytest
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from helpers.patience import PATIENCE
from rclpy.qos import QoSProfile
from rclpy.service_introspection import ServiceIntrospectionState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from textual.app import App, ComposeResult
from textual.events import Paste
from textual.pilot import Pilot
from textual.widgets import TabbedContent, TextArea

import goalwire
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.top import data as top_data
from goalwire.apps.cli.top.app import Options, Top
from goalwire.apps.cli.top.dialogs import Confirmation, Form
from goalwire.apps.cli.top.tabs import TableTab, cell
from goalwire.transport.contract import EndpointKind

HOSTILE = '[bold red]x[/] [/nothing] [@click=app.leave]y \x1b[31mz'
SPELT = '[bold red]x[/] [/nothing] [@click=app.leave]y \\x1b[31mz'


@pytest.fixture
def transport_name() -> str:
    """The wires are tried with the whole command."""
    return 'goalwire_memory'


class Shown(NamedTuple):
    """A screen of `top`, and a robot to look at."""

    robot: goalwire.Node
    app: Top
    pilot: Pilot[Outcome]

    async def until(self, holds: Callable[[], object]) -> None:
        """Draw again and again until something holds."""
        async with asyncio.timeout(PATIENCE):
            while not holds():
                await self.pilot.pause(0.02)
                if not isinstance(self.app.screen, Form | Confirmation):
                    self.app.repaint()

    @property
    def text(self) -> str:
        """All that is on the screen."""
        return '\n'.join(strip.text.rstrip() for strip in self.app.screen._compositor.render_strips())

    async def sees(self, text: str) -> None:
        """Wait until a text is on the screen."""
        try:
            await self.until(lambda: text in self.text)
        except TimeoutError:
            raise AssertionError(f'no {text!r} in\n{self.text}') from None

    async def tab(self, key: str, name: str) -> TableTab:
        """Choose a tab."""
        await self.pilot.press(key)
        await self.until(lambda: self.app.query_one(TabbedContent).active == name)
        tab: TableTab = self.app.query_one(f'#{name}', TableTab)
        await self.until(lambda: self.app.focused is tab.table)
        return tab

    async def dialog(self, kind: type[Form | Confirmation]) -> Any:
        """Wait for a dialog that takes keys."""
        await self.until(lambda: isinstance(self.app.screen, kind))
        dialog = self.app.screen
        await self.until(lambda: isinstance(dialog, Form) or getattr(dialog, 'is_armed', False))
        return dialog

    def listened_to(self) -> set[str]:
        """The topics that `top` subscribes to, besides the log."""
        graph = self.robot.context.graph
        return {
            name
            for name in graph.names(EndpointKind.SUBSCRIPTION)
            for entity in graph.entities(EndpointKind.SUBSCRIPTION, name)
            if entity.node.name == '_top' and name not in {'/rosout', '/parameter_events', '/clock'}
        }


@asynccontextmanager
async def shown(options: Options | None = None, *, rows: int = 30) -> AsyncIterator[Shown]:
    """Show a robot without anything yet."""
    async with goalwire.Node('robot') as robot, goalwire.Node('_top') as node:
        app = Top(node, options or Options())
        async with app.run_test(size=(140, rows)) as pilot:
            yield Shown(robot, app, pilot)
        await app.close_data()
        assert app.fault is None


def run(coroutine: Coroutine[Any, Any, None]) -> None:
    """Run a test to its end; what it waits for has deadlines of its own."""
    asyncio.run(asyncio.wait_for(coroutine, 2.5 * PATIENCE))


def scenario(test: Callable[[], Any]) -> Callable[[Any], None]:
    """Run an `async def` test in an isolated world."""

    def play(isolated: dict[str, str]) -> None:
        run(test())

    play.__doc__ = test.__doc__
    return play


async def _fibonacci(goal: Any) -> Fibonacci.Result:
    goal.feedback(sequence=[0, 1, 1])
    if goal.request.order > 1:
        await asyncio.Event().wait()
    return Fibonacci.Result(sequence=[0, 1])


@scenario
async def test_each_tab_shows_what_there_is() -> None:
    async with shown() as on:
        on.robot.publisher(String, 'chatter')
        on.robot.publisher(String, '_secret')
        on.robot.service(Trigger, 'reset', lambda _request: Trigger.Response())
        on.robot.action_server(Fibonacci, 'count', _fibonacci)
        await on.sees('goalwire top  1 nodes, 3 topics, 1 services, 1 actions')
        await on.sees('/robot')
        await on.tab('2', 'topics')
        await on.sees('/chatter')
        assert 'std_msgs/msg/String' in on.text
        assert '_secret' not in on.text
        await on.tab('3', 'services')
        await on.sees('/reset')
        assert 'describe_parameters' not in on.text
        await on.pilot.press('h')
        await on.sees('/robot/describe_parameters')
        await on.tab('2', 'topics')
        await on.sees('/_secret')
        await on.tab('4', 'goals')
        await on.sees('/count')
        await on.tab('1', 'nodes')
        await on.pilot.press('i')
        await on.sees('  Service Servers:')


@scenario
async def test_only_what_is_on_the_screen_is_listened_to() -> None:
    async with shown(rows=20) as on:
        for number in range(60):
            on.robot.publisher(String, f'topic_{number:02}')
        assert on.listened_to() == set()
        tab = await on.tab('2', 'topics')
        await on.until(lambda: len(tab._rows) == 62 and on.listened_to())
        assert '/topic_00' in on.listened_to()
        assert len(on.listened_to()) < 25
        await on.pilot.press('ctrl+end')
        await on.until(lambda: '/topic_59' in on.listened_to() and '/topic_00' not in on.listened_to())
        await on.tab('1', 'nodes')
        await on.until(lambda: on.listened_to() == set())


@scenario
async def test_a_rate_is_measured_while_it_is_on_the_screen() -> None:
    async with shown() as on:
        publisher = on.robot.publisher(String, 'chatter')
        tab = await on.tab('2', 'topics')
        await on.until(lambda: '/chatter' in on.listened_to())

        def has_rate() -> bool:
            publisher.publish(data='x')
            return '/chatter' in tab._rows and float(tab._rows['/chatter'][1].plain or 0) > 0

        await on.until(has_rate)
        assert tab._rows['/chatter'][2].plain.endswith('B')


def test_what_is_too_much_is_measured_for_a_moment(
    isolated: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(top_data, 'HEAVY', 1000)

    async def test() -> None:
        async with shown() as on:
            publisher = on.robot.publisher(String, 'camera')
            tab = await on.tab('2', 'topics')
            await on.until(lambda: '/camera' in on.listened_to())

            def is_paused() -> bool:
                if '/camera' in on.listened_to():
                    publisher.publish(data='x' * 100_000)
                return 'measured for a moment' in tab._rows['/camera'][-1].plain

            await on.until(is_paused)
            await on.until(lambda: on.listened_to() == set() - {'/parameter_events'})
            await on.until(lambda: tab.chosen == '/camera')
            await on.pilot.press('m')
            await on.until(lambda: '/camera' in on.listened_to())

            def has_rate() -> bool:
                publisher.publish(data='x' * 100_000)
                return float(tab._rows['/camera'][1].plain or 0) > 0

            await on.until(has_rate)
            assert '/camera' in on.listened_to()

    run(test())


@scenario
async def test_an_echo_shows_the_latest_message_as_it_is() -> None:
    async with shown() as on:
        qos = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        on.robot.publisher(String, 'chatter', qos=qos).publish(data=HOSTILE)
        tab = await on.tab('2', 'topics')
        await on.until(lambda: tab.chosen == '/chatter')
        await on.pilot.press('enter')
        await on.sees('[@click=app.leave]y')
        assert '\x1b' not in on.text
        await on.pilot.press('escape')
        await on.until(lambda: not on.app.query_one('#details').display)


@scenario
async def test_log_lines_are_shown_as_they_are() -> None:
    async with shown() as on:
        on.robot.logger.warning(HOSTILE)
        await on.pilot.press('5')
        await on.sees(f'[robot]: {SPELT}')
        assert '[WARN]' in on.text
        on.robot.logger.info('another one')
        await on.sees('another one')
        await on.pilot.press('slash', *'another')
        await on.until(lambda: SPELT not in on.text and 'another one' in on.text)


def test_names_are_shown_as_they_are() -> None:
    shown = cell('[red]a\n\x1b[31m[/]')
    assert (shown.plain, shown.spans) == ('[red]a\\n\\x1b[31m[/]', [])


@scenario
async def test_a_call_is_sent_once_it_is_confirmed() -> None:
    asked: list[int] = []

    def add(request: AddTwoInts.Request) -> AddTwoInts.Response:
        asked.append(request.a)
        return AddTwoInts.Response(sum=request.a + request.b)

    async with shown() as on:
        on.robot.service(AddTwoInts, 'add', add)
        tab = await on.tab('3', 'services')
        await on.until(lambda: tab.chosen == '/add')
        await on.pilot.press('c')
        form = await on.dialog(Form)
        assert form.query_one(TextArea).text == 'a: 0\nb: 0'
        form.query_one(TextArea).text = 'a: x'
        await on.pilot.press('f2')
        await on.sees('example_interfaces/srv/AddTwoInts')
        assert isinstance(on.app.screen, Form)
        form.query_one(TextArea).text = '{a: 20, b: 3}'
        await on.pilot.press('f2')
        await on.dialog(Confirmation)
        assert 'call /add' in on.text
        assert 'a: 20' in on.text
        await on.pilot.press('n')
        form = await on.dialog(Form)
        assert form.query_one(TextArea).text == '{a: 20, b: 3}'
        assert asked == []
        await on.pilot.press('f2')
        await on.dialog(Confirmation)
        await on.pilot.press('y')
        await on.sees('sum: 23')
        assert asked == [20]
        await on.until(lambda: tab._rows['/add'][3].plain == '1')
        assert tab._rows['/add'][8].plain == 'top'
        await on.pilot.press('i')
        await on.sees('latencies, as top sees:')


@scenario
async def test_what_is_pasted_or_typed_too_early_confirms_nothing() -> None:
    asked: list[Trigger.Request] = []

    def fire(request: Trigger.Request) -> Trigger.Response:
        asked.append(request)
        return Trigger.Response()

    async with shown() as on:
        on.robot.service(Trigger, 'fire', fire)
        tab = await on.tab('3', 'services')
        await on.until(lambda: tab.chosen == '/fire')
        await on.pilot.press('c')
        dialog = await on.dialog(Confirmation)  # there is nothing to fill in
        dialog.is_armed = False
        await on.pilot.press('y')
        assert on.app.screen == dialog
        dialog.is_armed = True
        dialog.post_message(Paste('y\n'))
        await on.pilot.pause()
        assert on.app.screen is dialog
        await on.pilot.press('escape')
        await on.until(lambda: on.app.screen is not dialog)
        await on.pilot.press('y', 'enter')
        await on.pilot.pause()
    assert asked == []


@scenario
async def test_a_confirmation_is_shown_as_it_is() -> None:
    async with shown() as on:
        await on.app.push_screen(Confirmation(HOSTILE, HOSTILE))
        await on.dialog(Confirmation)
        assert on.text.count(SPELT) == 2


@scenario
async def test_a_call_that_fails_is_told_in_one_line() -> None:
    async with shown(Options(timeout=0.2)) as on:

        async def never(_request: Any) -> Trigger.Response:
            await asyncio.Event().wait()
            return Trigger.Response()

        on.robot.service(Trigger, 'reset', never)
        tab = await on.tab('3', 'services')
        await on.until(lambda: tab.chosen == '/reset')
        await on.pilot.press('c')
        await on.dialog(Confirmation)
        await on.pilot.press('y')
        await on.sees("'/reset'")
        await on.until(lambda: tab._rows['/reset'][7].plain == '1')


@scenario
async def test_a_goal_is_sent_followed_and_cancelled() -> None:
    async with shown(Options(progress='sequence/10')) as on:
        on.robot.action_server(Fibonacci, 'count', _fibonacci)
        tab = await on.tab('4', 'goals')
        await on.until(lambda: tab.chosen == '/count')
        await on.until(lambda: on.listened_to() == {'/count/_action/status', '/count/_action/feedback'})
        await on.pilot.press('g')
        form = await on.dialog(Form)
        form.query_one(TextArea).text = 'order: 5'
        await on.pilot.press('f2')
        await on.dialog(Confirmation)
        await on.pilot.press('y')
        await on.sees('/count has accepted the goal')
        await on.sees('EXECUTING')
        await on.sees('█████████░░░░░░░░░░░░░░░░░░░░░  30 %')
        await on.sees('{"sequence": [0, 1, 1]}')
        await on.pilot.press('x')
        await on.sees('choose one of its goals')
        await on.pilot.press('q')
        await on.dialog(Confirmation)
        assert 'goals that were sent from here go on' in on.text
        await on.pilot.press('n')
        await on.until(lambda: not isinstance(on.app.screen, Confirmation))
        await on.pilot.press('down', 'i')
        await on.sees('- 0')
        await on.pilot.press('x')
        await on.dialog(Confirmation)
        assert 'cancel the goal ' in on.text
        await on.pilot.press('y')
        await on.sees('has ended: CANCELED')
        assert on.app.own_goals == {}
        await on.pilot.press('q')
        await on.until(lambda: on.app.return_value is not None)
        assert on.app.return_value is Outcome.OK


@scenario
async def test_all_goals_of_an_action_are_cancelled_by_one_request() -> None:
    async with shown() as on:
        on.robot.action_server(Fibonacci, 'count', _fibonacci)
        client = on.robot.action(Fibonacci, 'count')
        async with client.send(order=5), client.send(order=6):
            tab = await on.tab('4', 'goals')
            await on.until(lambda: sum('EXECUTING' in row[1].plain for row in tab._rows.values()) == 2)
            await on.pilot.press('X')
            await on.dialog(Confirmation)
            assert 'cancel ALL goals of /count' in on.text
            await on.pilot.press('y')
            await on.until(lambda: sum('CANCELED' in row[1].plain for row in tab._rows.values()) == 2)


@scenario
async def test_latencies_of_others_are_shown_where_introspection_is_on() -> None:
    async with shown() as on:
        import rclpy

        node = rclpy.create_node('other', context=on.robot.context)
        try:
            on.robot.service(Trigger, 'reset', lambda _request: Trigger.Response())
            client = node.create_client(Trigger, 'reset')
            client.configure_introspection(
                node.get_clock(), QoSProfile(depth=10), ServiceIntrospectionState.METADATA
            )
            tab = await on.tab('3', 'services')
            await on.until(lambda: '/reset/_service_event' in on.listened_to())
            _ = client.call_async(Trigger.Request())
            await on.until(lambda: '/reset' in tab._rows and tab._rows['/reset'][8].plain == 'clients')
            assert tab._rows['/reset'][3].plain == '1'
        finally:
            node.destroy_node()


@scenario
async def test_a_filter_leaves_what_fits() -> None:
    async with shown() as on:
        on.robot.publisher(String, 'left/state')
        on.robot.publisher(String, 'right/state')
        tab = await on.tab('2', 'topics')
        await on.until(lambda: '/left/state' in tab._rows)
        await on.pilot.press('slash', *'left')
        await on.until(lambda: list(tab._rows) == ['/left/state'])
        await on.pilot.press('enter')
        await on.sees('filter: left')
        await on.pilot.press('slash', 'escape')
        await on.until(lambda: '/right/state' in tab._rows)


def test_what_is_drawn_before_the_table_is_idle_is_whole() -> None:
    """The screen may be drawn in between, and what was drawn is drawn again until it changes."""

    class Tab(TableTab):
        COLUMNS = ('name', 'of', 'type')

    class OneTab(App[None]):
        def compose(self) -> ComposeResult:
            with TabbedContent():
                yield Tab('1 Names', 'names')

    async def test() -> None:
        async with OneTab().run_test(size=(140, 20)) as pilot:
            tab = pilot.app.query_one(Tab)
            for name, whose in (
                ('/a', ''),
                ('/a', 'server'),
                ('/a', 'top'),
                ('/a/long/name', 'another server'),
            ):
                tab.show({name: [cell(name), cell(whose), cell('std_srvs/srv/Trigger')]})
                for _ in ('at once', 'when it was idle'):
                    drawn = [tab.table.render_line(y).text for y in (0, 1)]
                    assert drawn[1].split() == [name, *whose.split(), 'std_srvs/srv/Trigger']
                    assert drawn[0].index('type') == drawn[1].index('std_srvs')
                    await pilot.pause()

    run(test())


@scenario
async def test_a_tick_while_it_is_taken_down_is_no_fault() -> None:
    async with shown() as on:
        await on.app.query_one('#head').remove()
        on.app.repaint()
        await on.app.query_one('#details').remove()
        on.app.say('too late')


def test_a_fault_ends_it_and_is_kept(isolated: dict[str, str]) -> None:
    async def test() -> None:
        async with goalwire.Node('_top') as node:
            app = Top(node, Options())
            async with app.run_test():
                app.call_later(lambda: 1 / 0)
                async with asyncio.timeout(PATIENCE):
                    while app.fault is None:  # noqa: ASYNC110 - nothing tells it
                        await asyncio.sleep(0.01)
            await app.close_data()
            assert isinstance(app.fault, ZeroDivisionError)
            assert app.return_value is Outcome.FAILED

    run(test())
