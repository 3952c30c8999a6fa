"""The form below a topic's messages that publishes one message."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nicegui import ui

from goalwire.apps.console.page.send_form import SendForm
from goalwire.errors import GoalwireError, peer_text

if TYPE_CHECKING:
    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.draft import Draft


class PublishForm:
    """The form of one topic. It is empty until it is opened."""

    def __init__(self, page: Page, topic: str, type_name: str) -> None:
        self._page = page
        self._topic = topic
        self._type = type_name
        self._form: SendForm | None = None
        self._box = ui.element('div').classes('gw-stack')

    def open(self) -> None:
        """Show the form, with the message's defaults."""
        self._form = None
        self._box.clear()
        try:
            target = self._page.session.sender.target('topic', self._topic, self._type)
        except GoalwireError as error:
            self._page.tell(peer_text(error), 'negative')
            return
        with self._box:
            self._form = form = SendForm(self._page, target)
            form.keep_draft('topics')
            with ui.element('div').classes('gw-actions gw-send'):
                form.send_button('Publish', 'data-publish', self._publish)
                form.yaml_button()
                form.copy_buttons()

    def restore(self, draft: Draft) -> None:
        """Show again what was typed before the page was loaded anew, or before its connection was lost."""
        if self._form is None:
            self.open()
        if self._form is not None:
            self._form.restore(draft)

    async def _publish(self) -> None:
        form, page = self._form, self._page
        sending = None if form is None else await form.confirm('Publish this message?', 'Publish')
        if form is None or sending is None:
            return
        sent = await page.attempt(page.session.sender.publish_once(form.target, sending, page.rights))
        if sent is not None:
            page.tell(sent.problem or 'Published', 'warning' if sent.problem else 'positive')
