"""Frames of a web socket: JSON, CBOR, PNG and fragments, in both directions."""

from __future__ import annotations

import json
import math
from base64 import b64decode, b64encode
from binascii import Error as Base64Error
from collections.abc import Mapping
from io import BytesIO
from itertools import count
from typing import Any

from goalwire.apps.bridge.outbox import Frame
from goalwire.apps.bridge.rosbridge.values import number_items
from goalwire.errors import FieldValueError

COMPRESSIONS = ('none', 'png', 'cbor', 'cbor-raw')
_MOST_UNFINISHED = 16
"""The largest number of incomplete fragmented messages of one client."""
_LEAST_FRAGMENT = 100
"""The shortest allowed fragment, in characters: a shorter one would consist mostly of its JSON frame."""
_numbers = count(1)


class BadMessageError(ValueError):
    """A client sent an unreadable message; the text says why."""


# -- to clients ----------------------------------------------------------------------------------------------


def json_text(value: Any) -> str:
    """Return JSON without spaces."""
    return json.dumps(value, separators=(',', ':'))


def cbor(value: Any) -> bytes:
    """Return CBOR."""
    import cbor2

    return cbor2.dumps(value)


def frames(text: str, fragment_size: int | None = None, compression: str = 'none') -> list[Frame]:
    """Return the frames of a JSON message: as PNG on request, and in fragments if it is too long."""
    if compression == 'png':
        text = json_text({'op': 'png', 'data': _png(text)})
    if fragment_size is None or len(text) <= fragment_size:
        return [text]
    size = max(fragment_size, _LEAST_FRAGMENT)
    parts = [text[at : at + size] for at in range(0, len(text), size)]
    name = f'fragment:{next(_numbers)}'
    return [
        json_text({'op': 'fragment', 'id': name, 'data': part, 'num': number, 'total': len(parts)})
        for number, part in enumerate(parts)
    ]


def _png(text: str) -> str:
    """Return a text as base64 of a PNG whose pixels are its bytes, padded with line feeds."""
    from PIL import Image

    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = -(-len(data) // (3 * width))
    picture = Image.frombytes('RGB', (width, height), data.ljust(width * height * 3, b'\n'))
    file = BytesIO()
    picture.save(file, 'png')
    return b64encode(file.getvalue()).decode('ascii')


# -- from clients --------------------------------------------------------------------------------------------


def read_frame(frame: Frame) -> dict[str, Any]:
    """Return the operation that a frame holds, JSON or CBOR. Raises BadMessageError."""
    try:
        value = json.loads(frame) if isinstance(frame, str) else _read_cbor(frame)
    except RecursionError:
        raise BadMessageError('the message is nested too deeply') from None
    except BadMessageError:
        raise
    except ValueError as error:
        raise BadMessageError(f'the message is not JSON: {error}') from None
    if not isinstance(value, dict) or not isinstance(value.get('op'), str):
        raise BadMessageError("a message must be an object whose field 'op' names the operation")
    return value


def _read_cbor(data: bytes) -> Any:
    import cbor2

    try:
        return cbor2.loads(data, tag_hook=_read_tag)
    except (cbor2.CBORDecodeError, FieldValueError, ValueError) as error:
        raise BadMessageError(f'the message is not CBOR: {error}') from None


def _read_tag(*given: Any) -> object:
    """Read a tag of CBOR. Some releases of cbor2 pass their decoder as a first argument."""
    return number_items(next(each for each in given if hasattr(each, 'tag')))


class Assembler:
    """Joins fragments and unpacks PNG messages; incomplete ones may hold `limit` bytes."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._parts: dict[str, dict[int, str]] = {}
        """The incomplete messages by id, the oldest at the front."""

    def add(self, operation: Mapping[str, Any]) -> dict[str, Any] | None:
        """Take an operation `fragment` or `png`; return the operation in it once it is complete.

        Raises BadMessageError.
        """
        data, number, total = operation.get('data'), operation.get('num', 0), operation.get('total', 1)
        if not isinstance(data, str) or type(number) is not int or type(total) is not int:
            raise BadMessageError("a fragment needs the text 'data' and the numbers 'num' and 'total'")
        if not 0 <= number < total:
            raise BadMessageError(f"'num' is {number}, but 'total' is {total}: 'num' counts from 0")
        whole = data if total == 1 else self._collect(str(operation.get('id')), data, number, total)
        if whole is None:
            return None
        if operation['op'] == 'png':
            whole = self._unpack(whole)
        inner = read_frame(whole)
        if inner['op'] == operation['op']:
            raise BadMessageError(f"a '{inner['op']}' must not contain another one")
        return inner

    def _collect(self, name: str, data: str, number: int, total: int) -> str | None:
        parts = self._parts.setdefault(name, {})
        parts[number] = data
        if len(self._parts) > _MOST_UNFINISHED:
            del self._parts[next(iter(self._parts))]
        if sum(len(part) for each in self._parts.values() for part in each.values()) > self._limit:
            self._parts.clear()
            raise BadMessageError(f'the fragments are longer than {self._limit} bytes: all were dropped')
        if len(parts) < total:
            return None
        del self._parts[name]
        return ''.join(parts[at] for at in sorted(parts))

    def _unpack(self, text: str) -> str:
        from PIL import Image

        try:
            picture = Image.open(BytesIO(b64decode(text)), formats=('png',))
            if picture.width * picture.height * 3 > self._limit:
                raise BadMessageError(f'the picture holds more than {self._limit} bytes')
            return picture.convert('RGB').tobytes().decode().rstrip('\n')
        except (OSError, Base64Error, SyntaxError, UnicodeDecodeError, Image.DecompressionBombError) as error:
            raise BadMessageError(f'the picture is not a PNG of a message: {error}') from None
