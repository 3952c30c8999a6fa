"""Wording that errors share: what a peer sent as one safe line, what was meant, where a name is wrong."""

from __future__ import annotations

from collections.abc import Iterable

PEER_TEXT_LIMIT = 500
"""The largest number of characters that errors and logs show of a text that a peer sent."""

LONGEST_SHOWN = 255
"""How many characters an error shows of a name more than twice as long. DDS allows no longer names."""

_CONTROLS = (
    *range(0x20), *range(0x7F, 0xA0),  # C0, DEL, C1: line breaks, terminal escapes
    # characters that change the writing direction of a text
    0x061C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A),
    0x2028, 0x2029,  # further line breaks
)  # fmt: skip
_ESCAPED = {code: chr(code).encode('unicode_escape').decode() for code in _CONTROLS}


def did_you_mean(near: Iterable[str]) -> str:
    """Return "did you mean 'a' or 'b'?" for the names that were probably meant; '' if there are none."""
    quoted = [name if name.startswith("'") else f"'{name}'" for name in near]
    return f'did you mean {" or ".join(quoted)}?' if quoted else ''


def with_advice(text: str, advice: str) -> str:
    """Return a text and the advice what to do next as one line, joined by '; ', or by a space after '?'."""
    if not text or not advice:
        return text or advice
    return f'{text}{" " if text.endswith("?") else "; "}{advice}'


def peer_text(text: object, limit: int = PEER_TEXT_LIMIT) -> str:
    r"""Return a text that a peer sent as one line of at most `limit` characters, for an error or a log.

    Control characters are escaped (`\n`, `\x1b`): so a peer can neither forge lines nor control a terminal. A
    text that this function has returned before stays unchanged.
    """
    told = str(text)[: limit + 1].translate(_ESCAPED)
    return told if len(told) <= limit else told[: limit - 1] + '…'


def point_at(kind: str, name: str, reason: str, index: int) -> str:
    """Return ROS 2's text for a forbidden name. Of a name that is far too long, only the part around the
    fault is shown.
    """
    length = len(name)
    if length > 2 * LONGEST_SHOWN:
        start = max(0, min(index - LONGEST_SHOWN // 2, length - LONGEST_SHOWN))
        end = start + LONGEST_SHOWN
        name = f'{"…" if start else ""}{name[start:end]}{"…" if end < length else ""}'
        index += (1 if start else 0) - start
        reason = f'{reason} (it has {length:,} characters)'
    return f"Invalid {kind}: {reason}:\n  '{name}'\n   {' ' * index}^"
