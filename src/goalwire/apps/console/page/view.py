"""The base of every view, and the page as a view sees it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar

from nicegui import Client, background_tasks, ui

from goalwire.apps.console.entry import PRINCIPAL
from goalwire.apps.console.page.pacing import Pacer
from goalwire.apps.console.state.draft import Draft
from goalwire.apps.console.state.layout import Layout
from goalwire.apps.console.state.series import Series
from goalwire.errors import FieldValueError, GoalwireError, peer_text

if TYPE_CHECKING:
    from goalwire.apps.console.state.session import Session

T = TypeVar('T')
Tone: TypeAlias = Literal['positive', 'negative', 'warning', 'info']


class View:
    """One view of the console's page: built when the user chooses it, closed when the user leaves it."""

    name = ''
    title = ''
    icon = ''
    period = 0.5
    """Seconds between two refreshes, if the browser keeps up."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.rights = page.rights
        self.session: Session = page.session
        self.settings = page.session.settings
        self.node = page.session.node

    @classmethod
    def is_offered(cls, session: Session) -> bool:  # noqa: ARG003 - others look at the session
        """Return True if the page's list of views has this view."""
        return True

    def build(self) -> None:
        """Make the view's elements."""

    def refresh(self) -> None:
        """Send the changes to the browser."""

    def set_dark(self, dark: bool) -> None:
        """Choose dark or light colours for elements that do not follow the page's theme."""

    def resume(self, draft: Draft) -> bool:  # noqa: ARG002 - views with a form look at the draft
        """Show what was typed into this view's form before the page was loaded anew, or its connection lost.

        Returns False if the form cannot be shown yet, because its target is not there.
        """
        return True

    def why_not_shown(self) -> str:
        """Return why the visitor may not see this view; '' if the visitor may."""
        return ''

    def turning_to(self, choose: Callable[[str], T]) -> Callable[[str], T]:
        """Return `choose` for a click of the visitor: typed text that waits to be shown again is dropped."""

        def turn(name: str) -> T:
            self.page.draft = None
            return choose(name)

        return turn

    def close(self) -> None:
        """End the view's subscriptions."""


class RefusedView(View):
    """Stands in for a view that the visitor may not see, and says why."""

    def __init__(self, page: Page, reason: str) -> None:
        super().__init__(page)
        self._reason = reason

    def build(self) -> None:
        with ui.element('div').classes('gw-card'):
            ui.label(self._reason).classes('gw-note').props('data-refused')


class Page:
    """One browser's page: the shown view, and the task that refreshes it."""

    def __init__(self, client: Client, session: Session) -> None:
        self.client = client
        self.session = session
        request = client.request
        self.rights = session.rights_of(request.scope.get('state', {}).get(PRINCIPAL) if request else None)
        """The rights of the visitor who has opened this page."""
        self.robot = ''
        """The namespace of the selected robot, which views show and STOP stops."""
        self.is_dark = False
        self.layout = Layout()
        """The visitor's arrangement of the page. A view begins with it, and writes its changes there."""
        self.draft: Draft | None = None
        """The typed text that is not shown again yet."""
        self.plotted: dict[tuple[str, str], Series] = {}
        """By topic and path: the numbers that were plotted, which other views leave as they were."""
        self.view: View | None = None
        self.header: Callable[[], None] = lambda: None
        self.trusted: set[tuple[str, str]] = set()
        """Kind and name of the targets to which the user has allowed sending, until the page is closed."""
        self.own_goals: set[tuple[str, str]] = set()
        """The goals that are cancelled when the page is closed."""
        self.closed = False
        self._pacer = Pacer(client, self._refresh)
        self._leaving: asyncio.TimerHandle | None = None
        self._follows = False

    def follow_robots(self) -> None:
        """Follow the selected robot, until the page is closed."""
        self._follows = True
        self.session.select(self.robot)
        self.session.listeners.add(self.refresh_soon)

    def select_robot(self, namespace: str) -> None:
        """Select another robot for the whole page."""
        if namespace != self.robot:
            before, self.robot = self.robot, namespace
            self.session.select(namespace)
            self.session.deselect(before)
            self.refresh_soon()

    def show(self, view: View, container: Any) -> None:
        """Show another view."""
        if self.view is not None:
            self.view.close()
        self.view = view
        container.clear()
        with container:
            view.build()
        self._pacer.refresh_soon()

    async def pace(self) -> None:
        """Refresh the view again and again, until the page is closed."""
        await self._pacer.run()

    def _refresh(self) -> float:
        view = self.view
        if self.rights.problem():  # the visitor's name or token is no longer valid
            ui.run_javascript('location.reload()')
            self.close()
            return 0.5
        try:
            self.header()
            if view is not None:
                view.refresh()
                self.resume_draft()
        except GoalwireError as error:
            self.session.node.logger.warning(
                f'a page of the console cannot be refreshed: {peer_text(error)}', throttle_duration_sec=5.0
            )
        return view.period if view is not None else 0.5

    def resume_draft(self) -> None:
        """Show what was typed and is not shown again yet, if it belongs to this view and can be shown."""
        draft, view = self.draft, self.view
        if draft is not None and view is not None and draft.view == view.name and view.resume(draft):
            self.draft = None

    def refresh_soon(self) -> None:
        """Refresh the view at once."""
        self._pacer.refresh_soon()

    def close(self) -> None:
        """Close the page after the browser has left. Its goals go on, except for those in `own_goals`."""
        if self._follows:
            self._follows = False
            self.session.listeners.discard(self.refresh_soon)
            self.session.deselect(self.robot)
        self.closed = True
        self._pacer.close()
        if self.view is not None:
            self.view.close()
            self.view = None
        self._set_leaving(None)
        self._cancel_own_goals()

    def cancel_goals_after(self, seconds: float) -> None:
        """Cancel the goals in `own_goals` whenever the browser has been away for so long."""

        def leave() -> None:
            if not self.closed and not self.client.has_socket_connection:
                self._set_leaving(asyncio.get_running_loop().call_later(seconds, self._cancel_own_goals))

        self.client.on_disconnect(leave)
        self.client.on_connect(lambda: self._set_leaving(None))

    def _set_leaving(self, timer: asyncio.TimerHandle | None) -> None:
        if self._leaving is not None:
            self._leaving.cancel()
        self._leaving = timer

    def _cancel_own_goals(self) -> None:
        for action, goal_id in self.own_goals:
            goal = self.session.goals.get(action, goal_id)
            if goal is not None and goal.is_active:
                background_tasks.create(self._cancel(action, goal_id))
        self.own_goals.clear()

    async def _cancel(self, action: str, goal_id: str) -> None:
        try:
            await self.session.sender.cancel_as_asked(action, goal_id)
        except GoalwireError as error:
            self.session.node.logger.warning(f"a goal of '{action}' was not cancelled: {peer_text(error)}")

    # -- talking to the user ---------------------------------------------------------------------------------

    async def attempt(self, work: Awaitable[Any]) -> Any:
        """Await something and return its result; on an error show it to the user and return None."""
        try:
            return await work
        except FieldValueError as error:
            self.tell(str(error), 'warning')
        except (GoalwireError, TypeError, ValueError) as error:
            self.tell(peer_text(error, 400), 'negative')
        return None

    def tell(self, text: str, kind: Tone = 'positive') -> None:
        """Show a line of text for some seconds."""
        with self.client:
            ui.notify(
                text,
                type=kind,
                position='bottom-right',
                multi_line=len(text) > 90,
                html=False,
                textColor='white',
            )

    async def confirm(
        self, kind: str, name: str, title: str, text: str, button: str = 'Send', *, may_trust: bool = True
    ) -> bool:
        """Ask before something is sent, and return the answer; `text` describes the message.

        With `may_trust` the user may say not to be asked again for this kind and name.
        """
        if (kind, name) in self.trusted:
            return True
        with self.client, ui.dialog() as dialog, ui.card().classes('gw-confirm'):
            ui.label(title).classes('gw-title')
            ui.label(name).classes('gw-dim gw-mono')
            if text.strip():
                ui.label(text).classes('gw-code').style('width: 100%').props('data-confirm')
            again = ui.checkbox('Do not ask again for this name while the page is open')
            again.set_visibility(may_trust)
            with ui.row().classes('gw-actions').style('width: 100%; justify-content: flex-end'):
                ui.button('Cancel', on_click=lambda: dialog.submit(False)).props('flat dense no-caps')
                ui.button(button, on_click=lambda: dialog.submit(True)).props(
                    'unelevated dense no-caps color=primary data-send padding="4px 14px"'
                )
        with self.client:
            answer = await dialog
        if answer and again.value:
            self.trusted.add((kind, name))
        dialog.clear()
        dialog.delete()
        return bool(answer)


def duration(seconds: float) -> str:
    """Return a duration as a readable text."""
    if seconds < 1e-3:
        return f'{seconds * 1e6:.0f} µs'
    if seconds < 1:
        return f'{seconds * 1e3:.1f} ms'
    return f'{seconds:.2f} s' if seconds < 100 else f'{seconds:.0f} s'
