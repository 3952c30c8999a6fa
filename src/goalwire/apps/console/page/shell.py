"""The frame around the views: the bar with stop and battery, the list of views, the routes."""

from __future__ import annotations

import os
from contextlib import suppress
from time import monotonic
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI
from nicegui import Client, background_tasks, ui

from goalwire.apps.console.entry import SIGN_OUT
from goalwire.apps.console.page import site
from goalwire.apps.console.page.actions_view import ActionsView
from goalwire.apps.console.page.connection import DRAFT_EVENT, install_watch, watch_connection
from goalwire.apps.console.page.emergency_bar import EmergencyBar
from goalwire.apps.console.page.graph_view import GraphViewPage
from goalwire.apps.console.page.kept import ask_for_kept, keep_dark
from goalwire.apps.console.page.layout_menu import LayoutMenu
from goalwire.apps.console.page.logs_view import LogsView
from goalwire.apps.console.page.missions_view import MissionsView
from goalwire.apps.console.page.parameters_view import ParametersView
from goalwire.apps.console.page.record_view import RecordView, time_text
from goalwire.apps.console.page.robot_view import RobotView
from goalwire.apps.console.page.services_view import ServicesView
from goalwire.apps.console.page.site import install_site
from goalwire.apps.console.page.statistics_view import StatisticsView
from goalwire.apps.console.page.stop_requests import install_stop
from goalwire.apps.console.page.theme import set_colours
from goalwire.apps.console.page.topics_view import TopicsView
from goalwire.apps.console.page.view import Page, RefusedView, View
from goalwire.apps.console.state.draft import read_draft
from goalwire.apps.console.state.session import Session

VIEWS: tuple[type[View], ...] = (
    RobotView,
    MissionsView,
    ActionsView,
    ServicesView,
    TopicsView,
    ParametersView,
    GraphViewPage,
    LogsView,
    RecordView,
    StatisticsView,
)
_OLD_BATTERY_S = 5.0
_LOST = 'This is old. STOP is tried all the same, and says within 1 s if it failed. What you typed is kept.'


def install(application: FastAPI, session: Session) -> None:
    """Add the page of the live robot to a web application. Only once in a process."""
    install_watch(application)
    install_stop(application, session)
    style = install_site(application, session.meshes)

    @ui.page('/', reconnect_timeout=site.KEPT_S)
    def page(view: str = '', robot: str = '') -> None:
        Shell(ui.context.client, session, style).build(view, robot)


class Shell:
    """Builds one browser's page."""

    def __init__(self, client: Client, session: Session, style: str) -> None:
        self._page = Page(client, session)
        self._session = session
        self._style = style
        self._views = [kind for kind in VIEWS if kind.is_offered(session)]
        self._tabs: dict[str, Any] = {}
        self._view = ''
        self._robots: list[str] = []

    def build(self, view: str, robot: str) -> None:
        """Make the page and begin to refresh it. `robot` is selected if it is there."""
        page = self._page
        page.rights.note('open', 'the console', 'signed in')
        page.follow_robots()
        robots = self._session.robot_names()
        if robots:
            page.select_robot(robot if robot in robots else robots[0])
        ui.add_head_html(f'<link rel="stylesheet" href="{self._style}">')
        watch_connection(_LOST)
        self._dark = ui.dark_mode(value=None)
        set_colours()
        with ui.element('div').classes('gw-shell'):
            with ui.element('header').classes('gw-top'):
                self._bar()
            with ui.element('nav').classes('gw-rail'):
                for kind in self._views:
                    self._tab(kind)
            self._main = ui.element('main').classes('gw-main')
        self._emergency = EmergencyBar(page)
        page.header = self._refresh_bar
        ui.on(DRAFT_EVENT, self._take_draft)
        page.client.on_delete(page.close)
        page.cancel_goals_after(site.RECONNECT_S)
        names = {kind.name for kind in self._views}
        self._show(view if view in names else ('robot' if robots else 'graph'))
        background_tasks.create(self._begin())

    async def _begin(self) -> None:
        page = self._page
        kept = await ask_for_kept(page.client)
        with page.client:
            self._set_dark(kept.is_dark)
            if kept.layout:
                self._take_layout(kept.layout)
            page.draft = read_draft(kept.draft)
        await page.pace()

    def _take_layout(self, text: str) -> None:
        """Take the layout that the browser has kept; a text of another console's version is left alone."""
        view = self._view
        with suppress(ValueError):
            self._page.layout.take(text)
            self._page.layout.view = view  # the address names the view
            self._show_layout()

    def _take_draft(self, event: Any) -> None:
        """Take what the form shows after a lost connection: what was typed last may not have arrived."""
        self._page.draft = read_draft(str(event.args))
        self._page.resume_draft()  # before the click on Send that may follow

    def _show_layout(self) -> None:
        """Show the page anew, as its layout says."""
        offered = {kind.name for kind in self._views}
        name = self._page.layout.view if self._page.layout.view in offered else self._view
        self._view = ''
        self._show(name)

    # -- the bar ---------------------------------------------------------------------------------------------

    def _bar(self) -> None:
        node = self._session.node
        ui.element('span').classes('gw-brand-mark')
        ui.label('goalwire console').classes('gw-brand')
        self._robot = ui.select({}, on_change=self._choose_robot).props(
            'outlined dense options-dense data-robot aria-label="Robot"'
        )
        self._robot.classes('gw-robot')
        self._robot.set_visibility(False)
        ui.element('span').classes('gw-room')
        ui.element('span').classes('gw-break')
        wire = 'DDS' if 'cyclone' in os.environ.get('RMW_IMPLEMENTATION', '') else 'Zenoh'
        ui.label(f'{wire} · domain {node.context.get_domain_id()}').classes('gw-chip')
        self._nodes = ui.label('').classes('gw-chip').props('data-nodes')
        self._problems = ui.label('').classes('gw-chip bad').style('cursor: pointer')
        self._problems.on('click', lambda: self._show('graph'))
        if self._session.settings.read_only:
            ui.label('read-only').classes('gw-chip warn')
        if self._page.rights.who:
            self._who(self._page.rights.who)
        ui.element('div').classes('gw-spread')
        self._recording = (
            ui.label('').classes('gw-chip bad').style('cursor: pointer').props('data-record-chip')
        )
        self._recording.on('click', lambda: self._show('record'))
        self._goals = ui.label('').classes('gw-chip info').style('cursor: pointer')
        self._goals.on('click', lambda: self._show('actions'))
        self._battery = ui.label('').classes('gw-chip').props('data-battery')
        LayoutMenu(self._page, self._show_layout)
        self._theme = ui.button(icon='dark_mode', on_click=self._switch_dark).props(
            'flat dense round size=sm aria-label="Dark or light"'
        )
        self._theme.classes('gw-quiet').tooltip('Dark or light')
        self._seen_version = -1

    @staticmethod
    def _who(name: str) -> None:
        """Show who has signed in, with a button to sign out."""
        ui.label(name).classes('gw-chip').props('data-who').tooltip('You have signed in under this name')
        # A link: the browser follows it although the page is not connected yet, or not any more.
        out = ui.button(icon='logout').props(f'flat dense round size=sm data-sign-out href={SIGN_OUT}')
        out.props['aria-label'] = 'Sign out'
        out.classes('gw-quiet').tooltip('Sign out')

    def _refresh_bar(self) -> None:
        session = self._session
        graph = session.node.graph
        if graph.version != self._seen_version:
            self._seen_version = graph.version
            count = len(graph.nodes())
            is_alone = count <= 1
            self._nodes.set_text('nobody else on the wire' if is_alone else f'{count} nodes')
            self._nodes.classes(add='warn') if is_alone else self._nodes.classes(remove='warn')
            problems = len(session.problems())
            self._problems.set_text(f'{problems} mismatch' + ('es' if problems != 1 else ''))
            self._problems.set_visibility(problems > 0)
        self._refresh_robots()
        self._emergency.refresh()
        active = len(session.goals.active())
        self._goals.set_text(f'{active} goal' + ('s' if active != 1 else '') + ' active')
        self._goals.set_visibility(active > 0)
        recording = session.recording
        self._recording.set_visibility(recording.is_running or bool(recording.problem))
        self._recording.set_text(
            f'● {time_text(recording.seconds)}' if recording.is_running else 'recording failed'
        )
        vitals = session.vitals.get(self._page.robot)
        battery = None if vitals is None else vitals.battery
        self._battery.set_visibility(battery is not None)
        if vitals is not None and battery is not None:
            age = monotonic() - vitals.battery_at
            is_old = age > _OLD_BATTERY_S
            self._battery.set_text(
                f'battery {battery * 100:.0f} %' + (f', {age:.0f} s ago' if is_old else '')
            )
            tone = 'old' if is_old else 'good' if battery > 0.4 else 'warn' if battery > 0.15 else 'bad'
            self._battery.classes(add=tone, remove=' '.join({'good', 'warn', 'bad', 'old'} - {tone}))

    def _refresh_robots(self) -> None:
        """Offer the present robots. A selected robot stays selected when it is gone."""
        there, page = self._session.robot_names(), self._page
        if there and page.robot not in self._session.vitals:
            page.select_robot(there[0])  # selects the first robot that appears
        offered = sorted({*there, page.robot}) if there else [page.robot]
        state = [name if name in there else f'{name} (gone)' for name in offered]
        if state != self._robots:
            self._robots = state
            self._robot.set_options(
                {name: (name or '/') + ('' if name in there else ' (gone)') for name in offered},
                value=page.robot,
            )
            self._robot.set_visibility(len(offered) > 1)

    def _choose_robot(self, event: Any) -> None:
        if event.value is not None and event.value != self._page.robot:
            self._page.select_robot(str(event.value))
            self._put_address()

    def _switch_dark(self) -> None:
        self._set_dark(not self._page.is_dark)
        keep_dark(self._page.client, dark=self._page.is_dark)

    def _set_dark(self, dark: bool) -> None:
        self._page.is_dark = dark
        self._dark.set_value(dark)
        self._theme.props(f'icon={"light_mode" if dark else "dark_mode"}')
        if self._page.view is not None:
            self._page.view.set_dark(dark)

    # -- views -----------------------------------------------------------------------------------------------

    def _tab(self, kind: type[View]) -> None:
        with ui.element('button').classes('gw-tab').props(f'data-view={kind.name} type=button') as tab:
            ui.icon(kind.icon)
            ui.label(kind.title)
        tab.on('click', lambda: self._turn_to(kind.name))
        self._tabs[kind.name] = tab

    def _turn_to(self, name: str) -> None:
        self._page.draft = None  # the user has turned to something else
        self._show(name)

    def _show(self, name: str) -> None:
        if name == self._view:
            return
        self._view = self._page.layout.view = name
        for each, tab in self._tabs.items():
            tab.classes(add='chosen') if each == name else tab.classes(remove='chosen')
        kind = next(kind for kind in VIEWS if kind.name == name)
        with self._page.client:
            view = kind(self._page)
            reason = view.why_not_shown()
            self._page.show(RefusedView(self._page, reason) if reason else view, self._main)
            self._put_address()

    def _put_address(self) -> None:
        """Put the shown view into the browser's address, so that reloading shows the same view."""
        robot = f'&robot={quote(self._page.robot)}' if self._page.robot else ''
        ui.run_javascript(f"history.replaceState(null, '', '?view={self._view}{robot}')")
