"""The dialogs of `top`: filling in a message, and confirming it before it is sent."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from rich.text import Text
from textual.binding import Binding
from textual.containers import Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Footer, Static, TextArea

from goalwire.apps.cli.framework.failures import explain_error
from goalwire.apps.cli.framework.outcome import CommandError
from goalwire.apps.cli.framework.output import escape

if TYPE_CHECKING:
    from textual.app import ComposeResult
    from textual.binding import BindingType
    from textual.events import Key

    from goalwire.apps.cli.top.requests import Request

_CSS = """
    align: center middle;
    #box { width: 90%; max-width: 100; height: auto; max-height: 90%; border: round $accent; padding: 0 1; }
"""


class Form(ModalScreen[tuple[str, Any] | None]):
    """Lets the user write a message as YAML; returns text and message, or None if the user leaves."""

    CSS = f'Form {{ {_CSS} TextArea {{ height: auto; min-height: 5; max-height: 60vh; }} }}'
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('f2,ctrl+s', 'review', 'Review before sending'),
        Binding('escape', 'leave', 'Back'),
    ]

    def __init__(self, request: Request, text: str) -> None:
        super().__init__()
        self._request = request
        self._text = text

    def compose(self) -> ComposeResult:
        """Lay out the dialog."""
        with Vertical(id='box'):
            yield Static(Text(f'{self._request.title}  [{self._request.type_name}]', style='bold'))
            yield TextArea(self._text, id='values')
            yield Static(id='problem')
        yield Footer()

    def on_mount(self) -> None:
        """Focus the text."""
        self.query_one(TextArea).focus()

    def action_review(self) -> None:
        """Go on to the confirmation, or show why the message cannot be sent."""
        text = self.query_one(TextArea).text
        try:
            message = self._request.read(text)
        except CommandError as error:
            self.query_one('#problem', Static).update(Text(escape(explain_error(error)[1]), style='red'))
            return
        _ = self.dismiss((text, message))

    def action_leave(self) -> None:
        """Close the dialog and send nothing."""
        _ = self.dismiss(None)


class Confirmation(ModalScreen[bool]):
    """Shows what is about to be sent. One key sends it; any other closes the dialog.

    Keys that were typed before the dialog was visible, and pasted text, do not count as an answer.
    """

    CSS = f'Confirmation {{ {_CSS} #what {{ height: auto; max-height: 60vh; }} }}'
    _SCROLLS: ClassVar[dict[str, int]] = {'up': -1, 'down': 1, 'pageup': -10, 'pagedown': 10}

    def __init__(self, title: str, what: str, key: str = 'y', does: str = 'sends it') -> None:
        super().__init__()
        self._title = title
        self._what = what
        self._key = key
        self._does = does
        self.is_armed = False

    def compose(self) -> ComposeResult:
        """Lay out the dialog."""
        with Vertical(id='box'):
            yield Static(Text(escape(self._title), style='bold'))
            with VerticalScroll(id='what', can_focus=False):
                yield Static(Text(escape(self._what)))
            yield Static(' ', id='prompt')

    def on_mount(self) -> None:
        """Accept keys from the moment when the dialog is visible."""
        self.call_after_refresh(self._arm)

    def _arm(self) -> None:
        self.is_armed = True
        text = f'{self._key} {self._does}; any other key goes back'
        self.query_one('#prompt', Static).update(Text(text, style='bold yellow'))

    def on_key(self, event: Key) -> None:
        """Take the answer, yes or no."""
        event.stop()
        if not self.is_armed:
            return
        if event.key in self._SCROLLS:
            self.query_one('#what').scroll_relative(y=self._SCROLLS[event.key], animate=False)
        else:
            _ = self.dismiss(event.key == self._key)
