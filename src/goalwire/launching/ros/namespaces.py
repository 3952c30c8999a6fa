"""Namespaces of nodes, joined as launch files nest them."""

from __future__ import annotations

from typing import overload

from goalwire.rules.names import absolute_namespace


def is_root_namespace(ns: str) -> bool:
    """Return whether a namespace is `/`."""
    return ns == '/'


def is_namespace_absolute(ns: str) -> bool:
    """Return whether a namespace begins with a slash. Such a namespace gets no prefix."""
    return ns.startswith('/')


def prefix_namespace(base_ns: str | None, ns: str | None) -> str | None:
    """Put `base` before a relative namespace; return an absolute one unchanged. Both may be None."""
    if base_ns is None or ns is None:
        return base_ns if ns is None else ns
    if is_namespace_absolute(ns) or not base_ns:
        joined = ns
    elif not ns:
        joined = base_ns
    else:
        joined = f'{base_ns.rstrip("/")}/{ns}'
    return joined if is_root_namespace(joined) else joined.rstrip('/')


@overload
def make_namespace_absolute(ns: str) -> str: ...
@overload
def make_namespace_absolute(ns: None) -> None: ...
def make_namespace_absolute(ns: str | None) -> str | None:
    """Put a slash before a relative namespace; None stays None."""
    return None if ns is None else absolute_namespace(ns)


def join_namespace(base: str | None, own: str | None) -> str | None:
    """Join a base and a namespace, and make the result absolute; None if both are None."""
    joined = prefix_namespace(base, own)
    return None if joined is None else make_namespace_absolute(joined.rstrip('/'))
