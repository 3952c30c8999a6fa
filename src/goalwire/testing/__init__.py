"""Helpers for tests without a robot: an isolated graph, scripted servers, recorders, virtual time, faults.

Each name is imported when it is first asked for. The pytest plugin is goalwire.testing.plugin.
"""

TYPE_CHECKING = False  # typing's name; its import would take 5 ms

if TYPE_CHECKING:
    from goalwire.errors import DeadlockError as DeadlockError
    from goalwire.testing.action import Conduct as Conduct
    from goalwire.testing.action import FakeAction as FakeAction
    from goalwire.testing.answers import NEVER as NEVER
    from goalwire.testing.answers import After as After
    from goalwire.testing.answers import after as after
    from goalwire.testing.bags import Expect as Expect
    from goalwire.testing.calls import Outcome as Outcome
    from goalwire.testing.graph import Graph as Graph
    from goalwire.testing.log import Log as Log
    from goalwire.testing.programs import Program as Program
    from goalwire.testing.service import FakeService as FakeService
    from goalwire.testing.topics import Publisher as Publisher
    from goalwire.testing.topics import Recorder as Recorder
    from goalwire.testing.virtual.clock import VirtualClock as VirtualClock

_NAMES = {
    'errors': 'DeadlockError',
    'testing.action': 'Conduct FakeAction',
    'testing.answers': 'NEVER After after',
    'testing.bags': 'Expect',
    'testing.calls': 'Outcome',
    'testing.graph': 'Graph',
    'testing.log': 'Log',
    'testing.programs': 'Program',
    'testing.service': 'FakeService',
    'testing.topics': 'Publisher Recorder',
    'testing.virtual.clock': 'VirtualClock',
}
_ORIGINS = {name: origin for origin, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> object:
    origin = _ORIGINS.get(name)
    if origin is None:
        raise AttributeError(f"module 'goalwire.testing' has no attribute '{name}'")
    from importlib import import_module

    found: object = getattr(import_module(f'goalwire.{origin}'), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_ORIGINS})
