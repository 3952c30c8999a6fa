"""Bags as a library: `from goalwire.bag import Reader, Writer`; each name is imported when it is asked for.

Files of MCAP need the extra: `pip install 'goalwire[bag]'`.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    from goalwire.errors import BagError
    from goalwire.rosbag2.model import Message, Schema, Topic
    from goalwire.rosbag2.reader import Reader
    from goalwire.rosbag2.writer import Writer

_ORIGINS = {
    'BagError': 'goalwire.errors',
    'Message': 'goalwire.rosbag2.model',
    'Reader': 'goalwire.rosbag2.reader',
    'Schema': 'goalwire.rosbag2.model',
    'Topic': 'goalwire.rosbag2.model',
    'Writer': 'goalwire.rosbag2.writer',
}
__all__ = ['BagError', 'Message', 'Reader', 'Schema', 'Topic', 'Writer']


def __getattr__(name: str) -> object:
    origin = _ORIGINS.get(name)
    if origin is None:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    found: object = getattr(import_module(origin), name)
    globals()[name] = found
    return found
