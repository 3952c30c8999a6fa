"""The window of a program: a page in this machine's browser, which shows a picture and may send commands."""

from __future__ import annotations

import base64
import json
import socket
import sys
import threading
import webbrowser
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Mapping, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any, Self

from rclpy.utilities import remove_ros_args

from goalwire.web_admission import host_name, is_loopback

HOST = '127.0.0.1'
COMMAND_HEADER = 'X-Window-Command'
LONGEST_COMMAND = 1 << 16
MOST_WAITING = 300
"""The most changes that wait for a slow browser before it gets the whole picture again."""


class Window:
    """Serves the page, and sends each browser first the whole picture and then the changes.

    `describe` returns the whole picture; `receive` takes a command of the page, and None forbids commands.
    The threads of browsers call both under `lock`. Hold `lock` to change the picture, too.
    """

    def __init__(self, page: bytes, port: int = 0) -> None:
        """Listen on a port of this machine; 0 takes any free port. Raises OSError."""
        self.page = page
        self.lock = threading.Lock()
        self.describe: Callable[[], Mapping[str, Any]] = dict
        self.receive: Callable[[Mapping[str, Any]], None] | None = None
        self.is_closed = False
        self._streams: set[_Stream] = set()
        self._server = ThreadingHTTPServer((HOST, port), _Page)
        self._server.daemon_threads = True
        self._server.window = self  # type: ignore[attr-defined]
        self._thread = threading.Thread(target=self._serve, name='window')
        self._thread.start()

    @property
    def url(self) -> str:
        """The page's address."""
        return f'http://{HOST}:{self._server.server_port}/'

    def open(self) -> None:
        """Open the user's browser, on a thread: starting some browsers blocks."""
        threading.Thread(target=webbrowser.open, args=(self.url,), daemon=True, name='window-browser').start()

    def send(self, change: Mapping[str, Any]) -> None:
        """Send a change to every browser; the caller holds `lock`."""
        if self._streams:
            text = json.dumps(change)
            for stream in self._streams:
                stream.put(text)

    def close(self) -> None:
        """End the page and its threads."""
        with self.lock:
            self.is_closed = True
            for stream in self._streams:
                stream.wake()
        with socket.create_connection((HOST, self._server.server_port)):
            pass  # ends the server's wait for a connection
        self._thread.join()
        self._server.server_close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _serve(self) -> None:
        while not self.is_closed:
            self._server.handle_request()

    def attend(self, write: Callable[[bytes], object]) -> None:
        """Send events to one browser until it disconnects or the window is closed."""
        stream = _Stream(self.lock)
        with self.lock:
            self._streams.add(stream)
        try:
            while not self.is_closed:
                for text in stream.take(self):
                    write(f'data: {text}\n\n'.encode())
        except OSError:
            pass  # The browser has disconnected.
        finally:
            with self.lock:
                self._streams.discard(stream)


class _Stream:
    """The drawing that one browser has not received yet."""

    def __init__(self, lock: threading.Lock) -> None:
        self._changed = threading.Condition(lock)
        self._waiting: list[str] = []
        self._needs_all = True

    def put(self, text: str) -> None:
        """Add a change; the caller holds the lock."""
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append(text)
        else:
            self._waiting.clear()
            self._needs_all = True
        self._changed.notify()

    def wake(self) -> None:
        """End the wait of `take`; the caller holds the lock."""
        self._changed.notify()

    def take(self, window: Window) -> list[str]:
        """Wait for changes and return them."""
        with self._changed:
            self._changed.wait_for(lambda: self._needs_all or self._waiting or window.is_closed)
            if self._needs_all:
                self._needs_all = False
                self._waiting = []
                return [json.dumps(window.describe())]
            taken, self._waiting = self._waiting, []
            return taken


class _Page(BaseHTTPRequestHandler):
    """Answers a browser: the page at /, the events at /events, commands to /command."""

    @property
    def _window(self) -> Window:
        window: Window = self.server.window  # type: ignore[attr-defined]
        return window

    def _is_local(self) -> bool:
        is_local = is_loopback(host_name(self.headers.get('Host') or ''))
        if not is_local:
            self.send_error(403, 'this page is for browsers of its own machine')
        return is_local

    def do_GET(self) -> None:
        window = self._window
        if not self._is_local():
            return
        if self.path == '/':
            self._answer('text/html; charset=utf-8')
            self.wfile.write(window.page)
        elif self.path == '/events':
            self._answer('text/event-stream')
            window.attend(self._write)
        else:
            self.send_error(404)

    def do_POST(self) -> None:
        """Pass on a command. It needs COMMAND_HEADER, which pages of other sites cannot send."""
        window = self._window
        if not self._is_local():
            return
        if self.path != '/command' or window.receive is None or self.headers.get(COMMAND_HEADER) is None:
            self.send_error(404)
            return
        try:
            length = int(self.headers.get('Content-Length') or 0)
            if not 0 <= length <= LONGEST_COMMAND:
                raise ValueError('the command is too long')  # noqa: TRY301 - one answer to all that is wrong
            command = json.loads(self.rfile.read(length))
            if not isinstance(command, dict):
                raise ValueError('a command must be a JSON object')  # noqa: TRY004, TRY301
        except ValueError as error:
            self.send_error(400, str(error)[:80])
            return
        with window.lock:
            window.receive(command)
        self.send_response(204)
        self.end_headers()

    def _answer(self, kind: str) -> None:
        self.send_response(200)
        self.send_header('Content-Type', kind)
        self.send_header('Cache-Control', 'no-store')
        self.send_header('X-Frame-Options', 'DENY')
        self.send_header('Content-Security-Policy', "default-src 'self' 'unsafe-inline'; img-src data:")
        self.end_headers()

    def _write(self, data: bytes) -> None:
        self.wfile.write(data)
        self.wfile.flush()

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing: any client of the port could fill the terminal."""


def run_in_window(
    parser: ArgumentParser,
    page: bytes,
    shown: str,
    run: Callable[[Window, Namespace], int],
    argv: Sequence[str],
) -> int:
    """Open a window as the arguments say, and run a program in it; return the exit code.

    Every such program has the options --port and --no-open. `shown` is what the page shows, for the user.
    """
    parser.add_argument('--port', type=int, default=0, help='port of the page; a free one if it is not given')
    parser.add_argument('--no-open', action='store_true', help='do not open the browser')
    words = parser.parse_args(remove_ros_args(argv)[1:])
    try:
        window = Window(page, words.port)
    except (OSError, OverflowError) as error:
        print(f'{parser.prog}: no page at port {words.port}: {error}', file=sys.stderr)
        return 1
    with window:
        print(f'the {shown} are at {window.url}', flush=True)
        if not words.no_open:
            window.open()
        return run(window, words)


def to_data_url(png: bytes) -> str:
    """Return a picture as a data URL, for a page."""
    return f'data:image/png;base64,{base64.b64encode(png).decode()}'
