"""Turns a sent message into a program and into a command line, both ready to run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import goalwire
from goalwire.apps.console.state.form_model import FormField, in_one_line, plain
from goalwire.idl.field_values import NOW
from goalwire.records import record


@record
class Sending:
    """A call, goal or message that was sent."""

    kind: str
    """The kind: 'service', 'action' or 'topic'."""
    name: str
    type_name: str
    """The type, as 'pkg/srv/Name'."""
    fields: tuple[FormField, ...]
    values: Mapping[str, Any]
    """Return the fields that differ from a new message."""
    timeout: float | None = None
    attempts: int = 1
    """The number of attempts of a call, which share `timeout`."""

    @property
    def retry(self) -> goalwire.Retry | None:
        """The retry policy for `attempts`, which share the time equally; None for a single attempt."""
        if self.attempts < 2:
            return None
        each = None if self.timeout is None else round(self.timeout / self.attempts, 3)
        return goalwire.Retry(attempts=self.attempts, timeout=each)


def as_command(sending: Sending) -> str:
    """Return a command line of ros2, without deadline and attempts, because ros2 has no flags for them."""
    verb = {'service': 'service call', 'action': 'action send_goal', 'topic': 'topic pub'}[sending.kind]
    flags = {'service': '', 'action': ' --feedback', 'topic': ' --once'}[sending.kind]
    values = in_one_line(sending.values)
    name = shlex.quote(sending.name)
    return f'ros2 {verb}{flags} {name} {sending.type_name} {shlex.quote(values)}'


def as_python(sending: Sending) -> str:
    """Return a program for the asyncio API."""
    writer = _Writer()
    name = writer.class_of(sending.type_name)
    part = {'service': f'{name}.Request', 'action': f'{name}.Goal', 'topic': name}[sending.kind]
    body = [f'        message = {writer.message(part, sending.fields, sending.values)}']
    timeout = '' if sending.timeout is None else f', timeout={sending.timeout!r}'
    target = repr(sending.name)
    if sending.kind == 'service':
        retry = _retry(sending.retry)
        body += [
            f'        client = node.client({name}, {target}{retry})',
            f'        print(await client.call(message{timeout}))',
        ]
    elif sending.kind == 'action':
        body += [
            f'        client = node.action({name}, {target})',
            f'        async with client.send(message{timeout}) as run:',
            '            async for feedback in run.feedback:',
            '                print(feedback)',
            '            print(await run.result)',
        ]
    else:
        body += [
            f'        publisher = node.publisher({name}, {target})',
            '        await publisher.wait_for_subscribers(timeout=10.0)',
            '        publisher.publish(message)',
        ]
    imports = [
        f'from {module} import {", ".join(sorted(names))}' for module, names in sorted(writer.imports.items())
    ]
    lines = [
        'import asyncio',
        '',
        *imports,
        '',
        'import goalwire',
        '',
        '',
        'async def main():',
        "    async with goalwire.Node('from_console') as node:",
        *body,
        '',
        '',
        'asyncio.run(main())',
    ]
    return '\n'.join(lines) + '\n'


def _retry(retry: goalwire.Retry | None) -> str:
    if retry is None:
        return ''
    timeout = '' if retry.timeout is None else f', timeout={retry.timeout!r}'
    return f', retry=goalwire.Retry(attempts={retry.attempts}{timeout})'


class _Writer:
    """Writes messages as calls of their classes, and notes the imports they need."""

    def __init__(self) -> None:
        self.imports: dict[str, set[str]] = {}
        self._names: dict[str, str] = {}

    def message(self, cls: str, fields: tuple[FormField, ...], values: Mapping[str, Any]) -> str:
        known = {field.name: field for field in fields}
        given = ', '.join(f'{name}={self._value(known[name], value)}' for name, value in values.items())
        return f'{cls}({given})'

    def _value(self, field: FormField, value: Any) -> str:
        if field.kind == 'time' and value == NOW:
            return 'node.clock.now().to_msg()'
        if field.kind == 'message':
            return self.message(self.class_of(field.base), field.fields, value)
        if field.kind == 'messages':
            cls = self.class_of(field.base)
            return '[' + ', '.join(self.message(cls, field.fields, item) for item in value) + ']'
        if field.kind == 'time':
            given = ', '.join(f'{name}={number!r}' for name, number in value.items())
            return f'{self.class_of(field.base)}({given})'
        if field.base == 'byte':
            return f'[{", ".join(map(_byte, value))}]' if isinstance(value, list) else _byte(value)
        return repr(plain(value))

    def class_of(self, type_name: str) -> str:
        """Return the name of a class in the program; if it is taken, the package is put before it."""
        package, kind, name = type_name.split('/')
        known = self._names.setdefault(name, type_name) == type_name
        called = name if known else f'{package}_{kind}_{name}'
        imported = name if known else f'{name} as {called}'
        self.imports.setdefault(f'{package}.{kind}', set()).add(imported)
        return called


def _byte(value: Any) -> str:
    return repr(bytes([value])) if isinstance(value, int) else repr(value)
