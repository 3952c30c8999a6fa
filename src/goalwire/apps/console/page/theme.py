"""The light and the dark theme, and the colours of buttons, for all pages."""

from __future__ import annotations

from nicegui import Client, ui

_ANSWER_S = 5.0
"""How long the page waits for the user's choice; then it is light."""


def set_colours() -> None:
    """Choose the colours of buttons and notes."""
    ui.colors(primary='#4f46e5', negative='#dc2626', positive='#059669', warning='#b45309', dark='#131c2b')


async def ask_for_dark(client: Client) -> bool:
    """Return True if the user wants a dark page, by an earlier choice or the system's setting."""
    await client.connected()
    try:
        chosen = await client.run_javascript(
            "return localStorage.getItem('goalwire-dark') ?? "
            "String(matchMedia('(prefers-color-scheme: dark)').matches)",
            timeout=_ANSWER_S,
        )
    except TimeoutError:
        return False
    return bool(chosen == 'true')


def keep_dark(*, dark: bool) -> None:
    """Save the choice of the dark or the light theme in the browser."""
    ui.run_javascript(f"localStorage.setItem('goalwire-dark', '{str(dark).lower()}')")
