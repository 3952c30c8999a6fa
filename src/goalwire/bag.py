"""The library for bags: `from goalwire.bag import Reader, Writer`. Each name is imported when first used.

Files of MCAP need the extra: `pip install 'goalwire[bag]'`.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    from goalwire.apps.bag.answering import Answers
    from goalwire.apps.bag.live_comparison import Replay, ReplayOptions
    from goalwire.apps.bag.message_comparison import Difference, Tolerance
    from goalwire.apps.bag.options import PlayOptions, RecordOptions
    from goalwire.apps.bag.player import Player
    from goalwire.apps.bag.recorder import Recorder
    from goalwire.apps.bag.selection import Names, Selection
    from goalwire.errors import BagError
    from goalwire.rosbag2.model import Message, Schema, Topic
    from goalwire.rosbag2.reader import Reader
    from goalwire.rosbag2.writer import Writer

_ORIGINS = {
    'Answers': 'goalwire.apps.bag.answering',
    'BagError': 'goalwire.errors',
    'Difference': 'goalwire.apps.bag.message_comparison',
    'Message': 'goalwire.rosbag2.model',
    'Names': 'goalwire.apps.bag.selection',
    'PlayOptions': 'goalwire.apps.bag.options',
    'Player': 'goalwire.apps.bag.player',
    'Reader': 'goalwire.rosbag2.reader',
    'RecordOptions': 'goalwire.apps.bag.options',
    'Recorder': 'goalwire.apps.bag.recorder',
    'Replay': 'goalwire.apps.bag.live_comparison',
    'ReplayOptions': 'goalwire.apps.bag.live_comparison',
    'Schema': 'goalwire.rosbag2.model',
    'Selection': 'goalwire.apps.bag.selection',
    'Tolerance': 'goalwire.apps.bag.message_comparison',
    'Topic': 'goalwire.rosbag2.model',
    'Writer': 'goalwire.rosbag2.writer',
}
__all__ = [
    'Answers',
    'BagError',
    'Difference',
    'Message',
    'Names',
    'PlayOptions',
    'Player',
    'Reader',
    'RecordOptions',
    'Recorder',
    'Replay',
    'ReplayOptions',
    'Schema',
    'Selection',
    'Tolerance',
    'Topic',
    'Writer',
]


def __getattr__(name: str) -> object:
    origin = _ORIGINS.get(name)
    if origin is None:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    found: object = getattr(import_module(origin), name)
    globals()[name] = found
    return found
