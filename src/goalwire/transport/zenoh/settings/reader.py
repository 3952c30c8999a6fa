"""Reads and checks the files that the environment names, and the overrides.

This needs no eclipse-zenoh, so that a process with goalwire's own session need not import that.
"""

from __future__ import annotations

import os

from goalwire.errors import TransportError
from goalwire.fault_reports import LOGGER
from goalwire.transport.zenoh.settings import environment, json5, schema
from goalwire.transport.zenoh.settings.environment import Override
from goalwire.transport.zenoh.settings.values import Configuration, Json, Settings


def read_file(variable: str) -> Configuration | None:
    """Return the content of the file that a variable names; None if it names none. Raises TransportError."""
    uri = os.environ.get(variable)
    if not uri:
        return None
    path = _path_of(uri) if uri.startswith('file://') else uri
    try:
        with open(path, encoding='utf-8-sig') as file:  # noqa: PTH123 - pathlib opens by it
            text = file.read()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else 'it is not text in UTF-8'
        raise _unusable(variable, path, reason or str(error)) from None
    try:
        values = read_settings(text, is_yaml=path.endswith(('.yaml', '.yml')))
    except json5.Json5Error as error:
        raise _unusable(variable, path, str(error)) from None
    return Configuration(values, f"{variable} names '{path}'")


def read_settings(text: str, *, is_yaml: bool) -> Settings:
    """Return the settings in a configuration file's text. Raises Json5Error, with the line if it is known."""
    document = _from_yaml(text) if is_yaml else json5.read(text)
    values = document.value
    if not isinstance(values, dict):
        raise json5.Json5Error('it must hold one object: { … }')
    for fault in schema.faults(values):
        line = _line_of(fault.path, document.lines)
        raise json5.Json5Error(f'{line}{fault.path} takes {fault.expected}')
    return values


def _line_of(path: str, lines: dict[str, int]) -> str:
    while path and path not in lines:
        path = path.rpartition('/')[0]
    return f'line {lines[path]}: ' if path else ''


def _from_yaml(text: str) -> json5.Document:
    import yaml  # imported here: it takes 20 ms, and few files are YAML

    try:
        return json5.Document(yaml.safe_load(text), {})
    except (
        yaml.YAMLError,
        ValueError,
        RecursionError,
    ) as error:  # ValueError: for a date that does not exist
        raise json5.Json5Error(' '.join(str(error).split())) from None


def _unusable(variable: str, path: str, reason: str) -> TransportError:
    return TransportError(
        f"{variable} names '{path}', which cannot be used: {reason}; correct the file or unset {variable}"
    )


def _path_of(uri: str) -> str:
    # Imported here: it takes 2 ms, and few programs name a file by a URI.
    from urllib.parse import unquote, urlsplit

    return unquote(urlsplit(uri).path)


def read_overrides() -> list[tuple[str, Json]]:
    """Return the valid pairs of ZENOH_CONFIG_OVERRIDE. Others are reported, as rmw_zenoh does."""
    pairs, broken = environment.overrides()
    for part in broken:
        _warn(part, 'it is not of the form key/path=value')
    accepted = []
    for pair in pairs:
        path = pair.path.strip('/')
        try:
            value = json5.read(pair.value).value
        except json5.Json5Error as error:
            _warn_of(pair, f'its value is no JSON5: {error}')
            continue
        known = schema.find(path)
        if known is None:
            _warn_of(pair, f"'{path}' is not a setting of Zenoh's")
            continue
        wrong = next(schema.faults(value, path, known), None) or next(
            (schema.Fault(each, 'no such setting') for each in schema.unknown(value, path, known)), None
        )
        if wrong is not None:
            _warn_of(pair, f'{wrong.path} takes {wrong.expected}')
            continue
        accepted.append((path, value))
    return accepted


def _warn_of(pair: Override, why: str) -> None:
    _warn(f'{pair.path}={pair.value}', why)


def _warn(part: str, why: str) -> None:
    from goalwire.logging import get_logger  # imported here: needed only for a warning

    get_logger(LOGGER).warning(
        f"ZENOH_CONFIG_OVERRIDE: '{part}' is ignored: {why}; correct it or take it out"
    )
