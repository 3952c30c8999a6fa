"""Fields of messages by their path: 'pose.position.x', 'ranges[0]'."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from goalwire.apps.cli.framework.outcome import CommandError, Outcome

_STEP = re.compile(r'\.?([A-Za-z]\w*)|\[(-?\d+)\]')


def field_path(text: str) -> list[str | int]:
    """Return the steps of 'a.b[0].c'; raises CommandError."""
    steps: list[str | int] = []
    at = 0
    while at < len(text):
        match = _STEP.match(text, at)
        if match is None:
            raise CommandError(
                Outcome.BAD_VALUE, f"'{text}' is not a field", "write it like 'pose.position.x'"
            )
        steps.append(match[1] or int(match[2]))
        at = match.end()
    return steps


def field_value(message: Any, path: Sequence[str | int], text: str | None) -> Any:
    """Return the value at the end of a path; raises CommandError for an unknown field."""
    value = message
    for step in path:
        known: dict[str, str] = getattr(value, 'get_fields_and_field_types', dict)()
        try:
            value = value[step] if isinstance(step, int) else getattr(value, step if step in known else '')
        except (AttributeError, IndexError, TypeError):
            raise CommandError(
                Outcome.BAD_VALUE,
                f"the field '{text}': there is no '{step}'",
                f'its fields are: {", ".join(known)}' if known else 'name another one',
            ) from None
    return value
