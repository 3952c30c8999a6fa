"""Names and regular expressions that choose topics, as `bag record` and `bag play` take them."""

from __future__ import annotations

import re
from argparse import ArgumentTypeError
from collections.abc import Iterable

from goalwire.apps.cli.framework.lookup import full_name


def names(given: Iterable[str], what: str) -> frozenset[str]:
    """Return full names; raises CommandError for an invalid name."""
    return frozenset(full_name(name, what) for name in given)


def regular_expression(text: str) -> str:
    """Read a regular expression."""
    try:
        re.compile(text)
    except re.error as error:
        raise ArgumentTypeError(f"'{text}' is not a regular expression: {error}") from None
    return text
