"""The line that a page shows while it has no connection to the console, and the scripts that watch it."""

from __future__ import annotations

from pathlib import Path

from fastapi import FastAPI
from fastapi.responses import Response
from nicegui import ui

DRAFT_EVENT = 'goalwire-draft'
"""The event by which a page tells what its form shows, after it was without a connection."""
_SCRIPTS = ''.join(
    f'<script>{Path(__file__).with_name(name).read_text(encoding="utf-8")}</script>\n'
    for name in ('connection.js', 'drafts.js')
)
_LOST = """
<div class="gw-lost" data-lost role="alert" hidden>
  <b>No connection to the console</b> <span data-lost-for aria-hidden="true"></span>
  <div>{text} Trying again …</div>
</div>
"""


def install_watch(application: FastAPI) -> None:
    """Add the address at which pages ask whether the console is there."""

    @application.get('/console/here', include_in_schema=False)
    async def here() -> Response:
        return Response(status_code=204, headers={'Cache-Control': 'no-store'})


def watch_connection(text: str) -> None:
    """Watch the connection of the page that is being made; `text` is what the user should know without it."""
    ui.add_body_html(_LOST.format(text=text) + _SCRIPTS)
