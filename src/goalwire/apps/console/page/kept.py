"""A page's data that the browser has kept: theme, layout and a draft. All are asked for at once."""

from __future__ import annotations

import json
from typing import Any

from nicegui import Client

from goalwire.apps.console.page.view import Page
from goalwire.records import record

_ANSWER_S = 5.0
"""How long the page waits for the browser's answer; then the page begins without it."""
_THEME = 'goalwire-dark'
_LAYOUT = 'goalwire-layout'
_DRAFT = 'goalwire-draft'
_QUESTION = f"""return [
  localStorage.getItem('{_THEME}') ?? String(matchMedia('(prefers-color-scheme: dark)').matches),
  sessionStorage.getItem('{_LAYOUT}') ?? '', sessionStorage.getItem('{_DRAFT}') ?? '']"""


@record
class Kept:
    """The kept data of a browser. Its texts come from the browser, so nobody has checked them yet."""

    is_dark: bool = False
    """True if the user wants a dark page, by an earlier choice or the system's setting."""
    layout: str = ''
    """The layout of this tab; '' if it has none."""
    draft: str = ''
    """The text that was typed in this tab before it was loaded anew; '' if there is none."""


async def ask_for_kept(client: Client) -> Kept:
    """Return what the browser has kept; nothing if the browser does not answer in time."""
    await client.connected()
    try:
        answer: Any = await client.run_javascript(_QUESTION, timeout=_ANSWER_S)
    except TimeoutError:
        return Kept()
    if not isinstance(answer, list) or len(answer) != 3:
        return Kept()  # the page was closed, or something else than our script has answered
    theme, layout, draft = map(str, answer)
    return Kept(theme == 'true', layout, draft)


def keep_dark(client: Client, *, dark: bool) -> None:
    """Keep the choice of the dark or the light theme in the browser."""
    client.run_javascript(f"localStorage.setItem('{_THEME}', '{str(dark).lower()}')")


def keep_layout(page: Page) -> None:
    """Keep the page's layout in its tab of the browser, which has it again after a reload."""
    page.client.run_javascript(f"sessionStorage.setItem('{_LAYOUT}', {json.dumps(page.layout.as_json())})")
