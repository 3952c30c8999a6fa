"""The button in the bar that saves the page's layout to a file, and loads it from one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from goalwire.apps.console.page.kept import keep_layout
from goalwire.apps.console.page.view import Page
from goalwire.apps.console.state.layout import MOST_BYTES

_EVENT = 'goalwire-layout'
_FILE = 'goalwire-layout.json'
# The browser reads the file, since the console takes no uploads. A file that is too large stays there, and
# as many spaces stand for it, so that the console says why it refuses it.
_CHOOSE = f"""() => {{
    const input = document.createElement('input');
    input.type = 'file';
    input.accept = '.json,application/json';
    input.hidden = true;
    input.addEventListener('change', async () => {{
        const file = input.files[0];
        input.remove();
        if (!file) return;
        const is_small = file.size <= {MOST_BYTES};
        emitEvent('{_EVENT}', is_small ? await file.text() : ' '.repeat({MOST_BYTES + 1}));
    }});
    input.addEventListener('cancel', () => input.remove());
    document.body.append(input);
    input.click();
}}"""


class LayoutMenu:
    """A button with a menu: save, load, and the standard layout."""

    def __init__(self, page: Page, show: Callable[[], None]) -> None:
        """`show` shows the page anew, after its layout has changed."""
        self._page = page
        self._show = show
        with ui.button(icon='dashboard_customize').props(
            'flat dense round size=sm aria-label="Layout" data-layout'
        ) as button:
            button.classes('gw-quiet').tooltip('Layout')
            with ui.menu().props('auto-close'):
                ui.menu_item('Save the layout to a file', self._save).props('data-layout-save')
                ui.menu_item('Load a layout from a file…').props('data-layout-load').on(
                    'click', js_handler=_CHOOSE
                )
                ui.menu_item('Standard layout', self._reset).props('data-layout-reset')
        ui.on(_EVENT, self._load)

    def _save(self) -> None:
        ui.download.content(self._page.layout.as_json(), _FILE, 'application/json')

    def _load(self, event: Any) -> None:
        try:
            self._page.layout.take(str(event.args))
        except ValueError as error:
            self._page.tell(str(error), 'warning')
            return
        keep_layout(self._page)
        self._show()
        self._page.tell('The layout is loaded')

    def _reset(self) -> None:
        layout = self._page.layout
        view = layout.view
        vars(layout).update(vars(type(layout)()))
        layout.view = view
        keep_layout(self._page)
        self._show()
