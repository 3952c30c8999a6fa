"""A visitor's arrangement of a page: the view, the 3D scene, the plots. It is kept as JSON.

The text comes from a browser or from a file, so each value is checked. A layout chooses only what is shown;
it sends nothing, and the rights of the visitor hold for all that it names.
"""

from __future__ import annotations

import json
from typing import Any

MOST_BYTES = 256 << 10
_MOST_ITEMS = 2000
_MOST_LETTERS = 400
_MARK = 'goalwire_layout'
_VERSION = 1


class Layout:
    """The arrangement of one page."""

    def __init__(self) -> None:
        self.view = ''
        self.follows = True
        """True if the camera follows the robot."""
        self.camera: list[float] = []
        """The camera's place, and the place that it looks at; empty until the visitor has moved it."""
        self.fixed_frame = ''
        """The frame that stands still on the screen; '' for the topmost frame above the robot."""
        self.axes = False
        self.axis_names = True
        self.hidden_frames: list[str] = []
        """The frames whose axes are not drawn."""
        self.layers: dict[str, bool] = {}
        """By topic: whether the visitor has switched its layer on or off."""
        self.hidden_robots: list[str] = []
        """The namespaces of the robots that are not drawn beside the selected one."""
        self.topic = ''
        """The topic whose messages are shown."""
        self.plots: list[list[str]] = []
        """The plotted numbers: a topic, and the path of a number in its messages."""
        self.plot_span = 30
        """The seconds that the plot shows."""

    def as_json(self) -> str:
        """Return the layout as a text, for `take`."""
        return json.dumps({_MARK: _VERSION, **vars(self)}, indent=1)

    def take(self, text: str) -> None:
        """Take the values of a layout's text; values that it does not have become the standard ones.

        Raises ValueError for anything else, and then keeps the present values.
        """
        values = _read(text)
        fresh = Layout()
        for name, standard in vars(Layout()).items():
            value = values.get(name, standard)
            if not _fits(name, value, standard):
                raise ValueError(f"this layout cannot be used: its value '{name}' is not valid")
            setattr(fresh, name, value)
        vars(self).update(vars(fresh))


def _read(text: str) -> dict[str, Any]:
    if len(text) > MOST_BYTES:
        raise ValueError(f'a layout has at most {MOST_BYTES >> 10} KiB; this text is larger')
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        raise ValueError('this is not a layout of the console: the text is not JSON') from None
    version = values.get(_MARK) if isinstance(values, dict) else None
    if version != _VERSION:
        raise ValueError(f"this is not a layout that this console reads: '{_MARK}' should be {_VERSION}")
    return dict(values)


def _fits(name: str, value: Any, standard: object) -> bool:
    """Return True if a value has the type of the standard value, and a bounded size."""
    if name == 'camera':
        return _is_list(value) and len(value) in {0, 6} and all(map(_is_number, value))
    if name == 'plots':
        return _is_list(value) and all(map(_is_pair, value))
    if isinstance(standard, list):
        return _is_list(value) and _are_texts(value)
    if isinstance(standard, dict):
        return isinstance(value, dict) and len(value) <= _MOST_ITEMS and all(map(_is_switch, value.items()))
    if isinstance(standard, str):
        return _are_texts([value])
    if isinstance(standard, bool):
        return isinstance(value, bool)
    return isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= 3600


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e6


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and len(value) <= _MOST_ITEMS


def _is_pair(value: Any) -> bool:
    return _is_list(value) and len(value) == 2 and _are_texts(value)


def _is_switch(item: tuple[Any, Any]) -> bool:
    return _are_texts([item[0]]) and isinstance(item[1], bool)


def _are_texts(values: list[Any]) -> bool:
    return all(isinstance(each, str) and len(each) <= _MOST_LETTERS for each in values)
