"""Key expressions: checks that they are well formed, and whether they match each other.

A key consists of chunks between slashes; no chunk is empty. In an expression `*` stands for one chunk, `**`
for zero or more chunks, and `$*` within a chunk for any text or none. Wildcards do not match a chunk that
begins with `@`; only the same chunk does.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from goalwire.zenoh.protocol import bounds
from goalwire.zenoh.protocol.primitives import ZenohProtocolError

ANY_CHUNKS = '**'
ANY_CHUNK = '*'
ANY_TEXT = '$*'


def is_wild(expression: str) -> bool:
    """Return whether an expression has wildcards."""
    return '*' in expression


def plain_head(expression: str) -> str:
    """Return the first three chunks, or all of fewer; '' if there is a wildcard in them.

    Two expressions can only intersect if their heads are the same, or if one of these is ''. Three chunks
    divide the keys of ROS 2 well: many have the first two in common, a domain and a robot.
    """
    end = -1
    for _ in range(3):
        end = expression.find('/', end + 1)
        if end < 0:
            return '' if '*' in expression else expression
    return '' if '*' in expression[:end] else expression[:end]


def check(expression: str) -> str:
    """Return the expression if it is well formed, else raise ZenohProtocolError."""
    if '*' not in expression and '$' not in expression:
        if (
            expression
            and not _has_empty_chunk(expression)
            and '#' not in expression
            and '?' not in expression
        ):
            return expression
    elif all(map(_is_chunk, expression.split('/'))):
        return expression
    raise ZenohProtocolError(f"'{expression[:200]}' is not a key expression")


def _has_empty_chunk(expression: str) -> bool:
    return '//' in expression or expression[0] == '/' or expression[-1] == '/'


def _is_chunk(chunk: str) -> bool:
    if chunk in {ANY_CHUNK, ANY_CHUNKS}:
        return True
    rest = chunk.replace(ANY_TEXT, '')
    return bool(chunk) and not any(sign in rest for sign in '*$#?')


def canonical(expression: str) -> str:
    """Return the canonical form, in which an expression is sent. Raises ZenohProtocolError if malformed."""
    if '*' not in check(expression):
        return expression
    chunks = []
    for chunk in expression.split('/'):
        while ANY_TEXT * 2 in chunk:
            chunk = chunk.replace(ANY_TEXT * 2, ANY_TEXT)
        chunks.append(ANY_CHUNK if chunk == ANY_TEXT else chunk)
    return _ordered(chunks)


def _ordered(chunks: list[str]) -> str:
    """Move each `*` before the `**` that it follows, and drop repeated `**`."""
    out: list[str] = []
    at = 0
    while at < len(chunks):
        if chunks[at] not in {ANY_CHUNK, ANY_CHUNKS}:
            out.append(chunks[at])
            at += 1
            continue
        run = at
        while at < len(chunks) and chunks[at] in {ANY_CHUNK, ANY_CHUNKS}:
            at += 1
        out += [ANY_CHUNK] * chunks[run:at].count(ANY_CHUNK)
        out += [ANY_CHUNKS] * (ANY_CHUNKS in chunks[run:at])
    return '/'.join(out)


def intersects(one: str, other: str) -> bool:
    """Return whether some key matches both expressions."""
    if one == other:
        return True
    if '*' not in one:
        if '*' not in other:
            return False
        one, other = other, one
    # Most expressions have no wildcards
    if one.endswith('/**') and one.find('*') == len(one) - 2 and '*' not in other:
        head = one[:-2]
        return (other.startswith(head) and '/@' not in other[len(head) - 1 :]) or other == head[:-1]
    return _intersects(one, other)


def includes(wide: str, narrow: str) -> bool:
    """Return whether every key of `narrow` matches `wide`."""
    if wide == narrow:
        return True
    if '*' not in wide:
        return False
    if len(wide) + len(narrow) > bounds.CACHED_PAIR:
        return _chunks_cover(wide.split('/'), narrow.split('/'))
    return _includes(wide, narrow)


def _intersects(one: str, other: str) -> bool:
    if len(one) + len(other) > bounds.CACHED_PAIR:
        return _chunks_meet(one.split('/'), other.split('/'))
    return _intersects_cached(one, other)


@lru_cache(maxsize=1024)
def _intersects_cached(one: str, other: str) -> bool:
    return _chunks_meet(one.split('/'), other.split('/'))


@lru_cache(maxsize=1024)
def _includes(wide: str, narrow: str) -> bool:
    return _chunks_cover(wide.split('/'), narrow.split('/'))


def _is_verbatim(chunk: str) -> bool:
    return chunk[0] == '@'


def _chunks_meet(one: Sequence[str], other: Sequence[str]) -> bool:
    """Return whether some key matches both expressions. Walks along `one` with a set: the numbers of leading
    chunks of `other` that can match the chunks of `one` so far.
    """
    reached = {0}
    if ANY_CHUNKS in other:
        reached = _pass_any(reached, other)
    for chunk in one:
        after: set[int] = set()
        for at in reached:
            if chunk == ANY_CHUNKS:
                after.add(at)
                while at < len(other) and not _is_verbatim(other[at]) and at + 1 not in after:
                    at += 1
                    after.add(at)
            elif at < len(other):
                if other[at] == ANY_CHUNKS:
                    if not _is_verbatim(chunk):
                        after.add(at)
                elif _chunk_meets(chunk, other[at]):
                    after.add(at + 1)
        reached = _pass_any(after, other)
        if not reached:
            return False
    return len(other) in reached


def _pass_any(reached: set[int], chunks: Sequence[str]) -> set[int]:
    """Add the positions that are reached if `**` stands for no chunk."""
    for at in list(reached):
        while at < len(chunks) and chunks[at] == ANY_CHUNKS:
            at += 1
            reached.add(at)
    return reached


def _chunks_cover(wide: Sequence[str], narrow: Sequence[str]) -> bool:
    """As `_chunks_meet`, but every wildcard of `narrow` must have an equal or wider one in `wide`."""
    reached = {0}
    for chunk in wide:
        after: set[int] = set()
        for at in reached:
            if chunk == ANY_CHUNKS:
                after.add(at)
                while at < len(narrow) and not _is_verbatim(narrow[at]) and at + 1 not in after:
                    at += 1
                    after.add(at)
            elif at < len(narrow) and _chunk_covers(chunk, narrow[at]):
                after.add(at + 1)
        reached = after
        if not reached:
            return False
    return len(narrow) in reached


def _chunk_meets(one: str, other: str) -> bool:
    """Return whether some chunk matches both. A chunk that begins with @ matches only itself."""
    if one == other:
        return True
    if _is_verbatim(one) or _is_verbatim(other):
        return False
    if ANY_CHUNK in (one, other):
        return True
    if ANY_TEXT not in one and ANY_TEXT not in other:
        return False
    return _texts_meet(one, other)


def _chunk_covers(wide: str, narrow: str) -> bool:
    """Return whether `wide` matches each chunk that `narrow` matches; `wide` is not `**`."""
    if wide == narrow:
        return True
    if narrow == ANY_CHUNKS or _is_verbatim(wide) or _is_verbatim(narrow):
        return False
    if wide == ANY_CHUNK:
        return True
    if narrow == ANY_CHUNK or ANY_TEXT not in wide:
        return False
    return _text_covers(wide, narrow)


def _texts_meet(one: str, other: str) -> bool:
    """Return whether some text matches two chunks, of which at least one has `$*`. Takes linear time.

    If both have `$*`, only their beginnings and ends matter: the `$*` of the other takes the rest.
    """
    if ANY_TEXT in one and ANY_TEXT in other:
        head, tail = one.partition(ANY_TEXT)[0], one.rpartition(ANY_TEXT)[2]
        other_head, other_tail = other.partition(ANY_TEXT)[0], other.rpartition(ANY_TEXT)[2]
        return (head.startswith(other_head) or other_head.startswith(head)) and (
            tail.endswith(other_tail) or other_tail.endswith(tail)
        )
    return _text_covers(one, other) if ANY_TEXT in one else _text_covers(other, one)


def _text_covers(wide: str, narrow: str) -> bool:
    """Return whether all texts that match `narrow` match `wide`, which has `$*`.

    A `$*` in `narrow` is treated as plain text. Only a `$*` in `wide` can match it, since the pieces of
    `wide` between its `$*` contain no '$'.
    """
    first, *parts, last = wide.split(ANY_TEXT)
    end = len(narrow) - len(last)
    if not (narrow.startswith(first) and narrow.endswith(last)) or end < len(first):
        return False
    at = len(first)
    for part in parts:
        found = narrow.find(part, at, end)
        if found < 0:
            return False
        at = found + len(part)
    return True
