"""Copies of collections that other threads change meanwhile."""

from __future__ import annotations

from collections import deque
from typing import TypeVar

T = TypeVar('T')


def copy_of(items: deque[T]) -> deque[T]:
    """Return a copy of a deque.

    Under the GIL no other thread can run while a deque is copied. Without it, up to Python 3.14, `copy` goes
    through the deque without its lock, and raises RuntimeError if another thread appends or takes something
    meanwhile. The copy is tried again then, until nobody changes the deque for the few microseconds that a
    copy takes. Source: cpython issue 144809.
    """
    while True:
        try:
            return items.copy()
        except RuntimeError:
            continue
