"""The colours of buttons and notes, for all pages."""

from __future__ import annotations

from nicegui import ui


def set_colours() -> None:
    """Choose the colours of buttons and notes."""
    ui.colors(primary='#4f46e5', negative='#dc2626', positive='#059669', warning='#b45309', dark='#131c2b')
