"""A form for sending, with its buttons for sending, confirming and copying."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from nicegui import ui

from goalwire.apps.console.page.forms import Form
from goalwire.apps.console.page.parts import LiveTable, copy_buttons, forbid
from goalwire.apps.console.page.view import duration
from goalwire.apps.console.state.form_model import in_one_line
from goalwire.apps.console.state.snippets import Sending, as_command, as_python
from goalwire.errors import FieldValueError
from goalwire.observe.clock import time_of_day

if TYPE_CHECKING:
    from goalwire.apps.console.page.view import Page
    from goalwire.apps.console.state.draft import Draft
    from goalwire.apps.console.state.sending import Sent, Target


class SendForm:
    """The form of a service, action or topic.

    A value that does not fit is reported, and nothing is sent or copied.
    """

    def __init__(self, page: Page, target: Target, values: Mapping[str, Any] | None = None) -> None:
        """`values` are the first content of the form; without them it has the message's defaults."""
        self.target = target
        self._page = page
        self._form = Form(target.fields, target.defaults, values or {})
        self._deadline: ui.number | None = None
        self._attempts: ui.number | None = None
        self._history: LiveTable | None = None
        self._used: Callable[[Sent], None] | None = None

    def keep_draft(self, view: str) -> None:
        """Keep what is typed over a reload of the page; `view` is the name of the view with the form."""
        self._form.name_draft(view, self.target.name)

    def restore(self, draft: Draft) -> None:
        """Show again what was typed before the page was loaded anew, or before its connection was lost."""
        self._form.restore(draft)
        for field, text in ((self._deadline, draft.deadline), (self._attempts, draft.attempts)):
            if field is not None:
                with suppress(ValueError):
                    field.value = float(text) if text else None

    # -- the form's buttons ----------------------------------------------------------------------------------

    def send_button(self, text: str, mark: str, press: Callable[[], Awaitable[None]]) -> None:
        """Add the button that sends; it is disabled and says why if the visitor may not send there."""
        button = ui.button(text, icon='send', on_click=press).props(
            f'unelevated dense no-caps color=primary {mark} padding="4px 14px"'
        )
        reason = self._page.rights.why_not_send(self.target.kind, self.target.name)
        forbid(button, reason)
        if reason:
            ui.label(reason).classes('gw-note').props('data-refused')

    def deadline_field(self, seconds: float | None) -> None:
        """Add the field for the deadline; `seconds` is its first value."""
        self._deadline = (
            ui.number('Deadline [s]', value=seconds, placeholder='none', min=0.1, step=1)
            .props('outlined dense data-deadline')
            .style('width: 112px')
        )

    def attempts_field(self) -> None:
        """Add the field for the number of attempts if no answer comes."""
        self._attempts = (
            ui.number('Attempts', value=1, min=1, max=10, step=1, precision=0)
            .props('outlined dense data-attempts')
            .style('width: 92px')
        )
        self._attempts.tooltip(
            'More than one: the request may be handled twice, so the service must be idempotent'
        )

    def yaml_button(self) -> None:
        """Add the button that shows the form as YAML, and as a form again."""
        ui.button('YAML', icon='data_object', on_click=self._toggle_yaml).props(
            'flat dense no-caps data-toggle-yaml'
        )

    def copy_buttons(self) -> None:
        """Add the buttons that copy the message to be sent."""
        copy_buttons(lambda: self._copy(as_python), lambda: self._copy(as_command))

    def history(self, used: Callable[[Sent], None] | None = None) -> None:
        """Add the table of messages that were sent to that name from here; a click on a row fills the form.

        `used` is called with the chosen message.
        """
        self._used = used
        took = {'name': 'took', 'label': 'Took', 'align': 'right', 'width': '84px'}
        kind = self.target.kind
        self._history = LiveTable(
            [
                {'name': 'at', 'label': 'At', 'width': '84px'},
                *([{'name': 'who', 'label': 'Who', 'width': '84px'}] if self._page.rights.who else []),
                *([took] if kind == 'service' else []),
                {'name': 'what', 'label': 'Request' if kind == 'service' else 'Goal', 'mono': True},
            ],
            empty=f'{"Calls" if kind == "service" else "Goals"} from here are kept while the console runs.',
            on_row=self._use_again,
        )
        self.put_history()

    @property
    def sent(self) -> Sequence[Sent]:
        """Return the messages that this console sent to that name, the latest last."""
        return self._page.session.sender.history.get((self.target.kind, self.target.name), ())

    def put_history(self) -> None:
        """Show the messages that were sent since the last call."""
        if self._history is not None:
            self._history.put(
                [_history_row(sent, bool(self._page.rights.who)) for sent in reversed(self.sent)]
            )

    def _use_again(self, key: str) -> None:
        for sent in self.sent:
            if f'{sent.at}' == key:
                self._form.fill(sent.sending.values)
                if self._used is not None:
                    self._used(sent)

    def _toggle_yaml(self) -> None:
        try:
            self._form.toggle_yaml()
        except FieldValueError as error:
            self._tell(error)

    def _tell(self, error: FieldValueError) -> None:
        self._page.tell(str(error), 'warning')
        if error.path and not self._form.is_yaml:
            self._form.show(error.path)

    def _copy(self, write: Callable[[Sending], str]) -> str | None:
        sending = self.sending()
        return None if sending is None else write(sending)

    # -- the form's content ----------------------------------------------------------------------------------

    def fill(self, values: Mapping[str, Any]) -> None:
        """Fill in other values; fields without one get their defaults."""
        self._form.fill(values)

    def sending(self) -> Sending | None:
        """Return the message to send; if a value does not fit, tell the user and return None."""
        deadline = self._deadline.value if self._deadline is not None else None
        attempts = self._attempts.value if self._attempts is not None else None
        try:
            return self.target.sending(
                self._form.values(), float(deadline) if deadline else None, int(attempts or 1)
            )
        except FieldValueError as error:
            self._tell(error)
            return None

    async def confirm(self, title: str, button: str) -> Sending | None:
        """Return the message to send after the user has confirmed it; None if the user refuses."""
        sending = self.sending()
        if sending is None:
            return None
        kind, name = self.target.kind, self.target.name
        asked = await self._page.confirm(kind, name, title, as_command(sending), button)
        return sending if asked else None


def _history_row(sent: Sent, has_names: bool) -> dict[str, Any]:
    values = in_one_line(sent.sending.values)
    what = f'{sent.problem} · {values}' if sent.problem else values
    took = [duration(sent.seconds)] if sent.sending.kind == 'service' else []
    who = [{'text': sent.who, 'title': sent.who}] if has_names else []
    cells = [time_of_day(sent.at), *who, *took, {'text': what, 'title': what}]
    return {'key': f'{sent.at}', 'cells': cells, **({'tone': 'bad'} if sent.problem else {})}
