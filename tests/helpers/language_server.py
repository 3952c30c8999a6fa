"""A language server, as an editor talks to it: JSON-RPC over its standard input and output."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from helpers.fresh import clean_environment


class LanguageServer:
    """One server with one folder open; texts are opened in it, and asked about by line and character."""

    def __init__(self, command: Sequence[str | Path], folder: Path) -> None:
        self._folder = folder
        self._number = 0
        self._process = subprocess.Popen(
            command, cwd=folder, env=clean_environment(), stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def __enter__(self) -> Self:
        root = self._folder.as_uri()
        client = {
            'textDocument': {'completion': {}, 'hover': {'contentFormat': ['plaintext']}},
            'workspace': {'configuration': True},
        }
        self.request('initialize', processId=None, rootUri=root, capabilities=client)
        self._send({'method': 'initialized', 'params': {}})
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.request('shutdown')
        self._send({'method': 'exit'})
        self._process.communicate(timeout=60)

    def open(self, name: str, text: str) -> str:
        """Open a text as if it were a file of the folder; return its address."""
        uri = (self._folder / name).as_uri()
        document = {'uri': uri, 'languageId': 'python', 'version': 1, 'text': text}
        self._send({'method': 'textDocument/didOpen', 'params': {'textDocument': document}})
        return uri

    def completions(self, uri: str, line: int, character: int) -> set[str]:
        """Return the names that are offered at a place."""
        found = self._ask('completion', uri, line, character)
        items = found['items'] if isinstance(found, dict) else found or []
        return {item['label'].partition('(')[0] for item in items}

    def hover(self, uri: str, line: int, character: int) -> str:
        """Return what is shown for the name at a place."""
        found = self._ask('hover', uri, line, character)
        contents = found['contents'] if found else ''
        return contents['value'] if isinstance(contents, dict) else str(contents)

    def _ask(self, what: str, uri: str, line: int, character: int) -> Any:
        position = {'line': line, 'character': character}
        return self.request(f'textDocument/{what}', textDocument={'uri': uri}, position=position)

    def request(self, method: str, **params: Any) -> Any:
        """Ask, and wait for the answer. A server that asks meanwhile for settings is told of this Python."""
        self._number += 1
        self._send({'id': self._number, 'method': method, 'params': params or None})
        while True:
            message = self._receive()
            if message.get('id') == self._number and 'method' not in message:
                return message.get('result')
            if 'id' in message and 'method' in message:
                items = message.get('params', {}).get('items', [])
                settings = [{'pythonPath': sys.executable} for _ in items]
                self._send({'id': message['id'], 'result': settings or None})

    def _send(self, message: dict[str, Any]) -> None:
        data = json.dumps({'jsonrpc': '2.0', **message}).encode()
        assert self._process.stdin is not None
        self._process.stdin.write(b'Content-Length: %d\r\n\r\n%b' % (len(data), data))
        self._process.stdin.flush()

    def _receive(self) -> dict[str, Any]:
        stream = self._process.stdout
        assert stream is not None
        length = 0
        while (header := stream.readline().strip()) != b'':
            name, _, value = header.partition(b':')
            if name.lower() == b'content-length':
                length = int(value)
        assert length, 'the server has ended'
        message: dict[str, Any] = json.loads(stream.read(length))
        return message
