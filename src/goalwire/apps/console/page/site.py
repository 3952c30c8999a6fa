"""The web application under every page: the style sheet, meshes, the web socket, and their limits."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

from fastapi import FastAPI
from fastapi.responses import FileResponse, PlainTextResponse, Response
from nicegui import Client, app, core, ui

from goalwire.errors import RemoteError

if TYPE_CHECKING:
    from goalwire.apps.console.state.meshes import Meshes

MOST_PAGES = 100
"""The largest number of pages in all browsers; a page to which no browser connects counts for a minute."""
RECONNECT_S = 10.0
"""Seconds that a browser without a connection may take to come back; then the goals that are to end with
its page are cancelled. It also sets how often connections are tested: every 8 s, and 4 s for the answer."""
KEPT_S = 60.0
"""Seconds that a page is kept without a connection. A browser that comes back later loads the page anew."""
_MEDIA = {'.png': 'image/png', '.jpg': 'image/jpeg', '.jpeg': 'image/jpeg'}
_STYLE = Path(__file__).with_name('style.css')


def install_site(application: FastAPI, meshes: Meshes) -> str:
    """Add the resources of pages to an application, and return the address of the style sheet.

    Only once in a process.
    """
    app.add_static_file(local_file=_STYLE, url_path='/console/style.css', max_cache_age=3600)

    @app.get('/console/mesh/{key}', include_in_schema=False)
    async def mesh(key: str) -> Response:
        file = meshes.file(key)
        if file is None:
            return PlainTextResponse('there is no such mesh\n', 404)
        if file.suffix.lower() == '.dae':
            try:
                return Response(await meshes.as_gltf(key), media_type='model/gltf-binary')
            except RemoteError as error:
                return PlainTextResponse(f'{error}\n', 422)
        return FileResponse(file, media_type=_MEDIA.get(file.suffix.lower(), 'application/octet-stream'))

    @app.exception_handler(404)
    def missing(_request: object, _error: Exception) -> Response:
        return PlainTextResponse('there is no such page\n', 404)  # NiceGUI's 404 pages stay in memory

    app.config.socket_io_js_transports = ['websocket']
    core.sio.eio.transports = ['websocket']
    ui.run_with(
        application,
        title='goalwire console',
        favicon=None,
        dark=None,
        tailwind=False,
        reconnect_timeout=RECONNECT_S,
        message_history_length=100,
        binding_refresh_interval=None,
        show_welcome_message=False,
    )
    return f'/console/style.css?{hashlib.sha256(_STYLE.read_bytes()).hexdigest()[:12]}'


def is_full() -> bool:
    """Return True if no more pages are allowed."""
    return len(Client.instances) >= MOST_PAGES
