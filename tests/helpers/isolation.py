"""Environments in which a test meets nobody but itself, however many test runs share the machine.

A test run claims one slot of the machine by holding a port. The slot gives it domain ids (valid for DDS
too: 1 to 230) and router ports below every system's ephemeral range, so nothing else takes them by chance.
"""

from __future__ import annotations

import atexit
import os
import shutil
import socket
import sys
import tempfile
from functools import cache
from itertools import count
from pathlib import Path

SLOTS = 23
_DOMAINS_PER_SLOT = 10
_PORTS_PER_SLOT = 400
_FIRST_PORT = 20_000
_FIRST_CLAIM = _FIRST_PORT + SLOTS * _PORTS_PER_SLOT

_OTHERS = ('AMENT_', 'COLCON_', 'CYCLONEDDS_', 'FASTRTPS_', 'GOALWIRE_', 'RCUTILS_', 'RMW_', 'ROS_', 'ZENOH_')
"""Beginnings of the variables that would let the machine's own ROS 2 into a test."""

WHOSE_SESSIONS = frozenset({'GOALWIRE_ZENOH', 'GOALWIRE_DDS'})
"""Say which sessions on Zenoh and DDS the tests, and programs that they start, open: hidden from none."""

BYTECODE = 'PYTHONPYCACHEPREFIX'
"""Says where Python keeps compiled modules."""

NETWORK = os.environ.get('GOALWIRE_TEST_NETWORK', 'rmw_zenoh_cpp')
"""The wire of tests with several processes that are not about a wire."""

_ports = count()
_domains = count()


@cache
def _claim() -> tuple[int, socket.socket]:
    """Return this run's slot and the socket that holds it until the process ends."""
    for slot in range(SLOTS):
        claim = socket.socket()
        try:
            claim.bind(('127.0.0.1', _FIRST_CLAIM + slot))
        except OSError:
            claim.close()
        else:
            return slot, claim
    raise RuntimeError(f'{SLOTS} test runs are under way on this machine; wait for one to end')


def claim_slot() -> None:
    """Take this run's slot now, so that no later check mistakes the socket for a test's."""
    _claim()


def free_port() -> int:
    """Return a port of this run that nobody listens on, and that this process has left to no other router."""
    slot, _ = _claim()
    for _ in range(_PORTS_PER_SLOT):
        port = _FIRST_PORT + slot * _PORTS_PER_SLOT + next(_ports) % _PORTS_PER_SLOT
        if _is_left(port):
            continue
        with socket.socket() as probe:
            if os.name == 'posix':
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(('127.0.0.1', port))
            except OSError:
                continue
            return port
    raise RuntimeError(f'no free port in {_PORTS_PER_SLOT} from {_FIRST_PORT + slot * _PORTS_PER_SLOT}')


def _is_left(port: int) -> bool:
    """Whether an earlier test in this process left the port to a router: goalwire offers none there again."""
    rendezvous = sys.modules.get('goalwire.transport.zenoh.rendezvous')
    return rendezvous is not None and bool(rendezvous.RENDEZVOUS.is_left(port))


def fresh_domain() -> int:
    """Return a domain id that no other test run uses, and this one has not used lately."""
    slot, _ = _claim()
    return 1 + slot * _DOMAINS_PER_SLOT + next(_domains) % _DOMAINS_PER_SLOT


@cache
def log_directory() -> Path:
    """Return where the processes of this test run put their log files; it goes with the run."""
    return _own_folder()


def keep_runs_within_runs_apart() -> None:
    """Have pytest, where a test starts it, use a folder of its own for temporary files.

    In the folder of all runs it would clear up after earlier ones: that can take minutes.
    """
    os.environ['PYTEST_DEBUG_TEMPROOT'] = str(_own_folder())


def _own_folder() -> Path:
    """Make a folder that goes with this test run."""
    folder = Path(tempfile.mkdtemp(prefix='goalwire-tests-'))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def keep_bytecode() -> None:
    """Have the programs that tests start, and pytest's workers, compile each module once.

    To compile goalwire takes longer than all the rest of a start, and each worker imports every test file.
    The byte code is kept in `build`, apart from the sources. That of temporary files goes with the next run:
    their paths are new each time. In a clone that is a temporary folder itself, it stays.
    """
    os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
    root = Path(__file__).resolve().parents[2]
    kept = os.environ.setdefault(BYTECODE, str(root / 'build' / 'bytecode'))
    sys.dont_write_bytecode, sys.pycache_prefix = False, kept
    temporary = Path(tempfile.gettempdir()).resolve()
    if 'PYTEST_XDIST_WORKER' not in os.environ and not root.is_relative_to(temporary):
        shutil.rmtree(Path(kept, *temporary.parts[1:]), ignore_errors=True)


def isolated_env(transport: str, log_dir: Path | None = None) -> dict[str, str]:
    """Return a whole environment for `transport`: own domain, own router port, own log directory."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(_OTHERS) or name in WHOSE_SESSIONS
    }
    return kept | {
        'RMW_IMPLEMENTATION': transport,
        'ROS_DOMAIN_ID': str(fresh_domain()),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'GOALWIRE_ROUTER_PORT': str(free_port()),
        'ROS_LOG_DIR': str(log_dir or log_directory()),
    }


def lease_variables(lease_s: float) -> dict[str, str]:
    """Return what has the others miss a program so long after its last sign, in place of ten seconds."""
    lease = f'<LeaseDuration>{lease_s}s</LeaseDuration>'
    return {
        'CYCLONEDDS_URI': f'<CycloneDDS><Domain><Discovery>{lease}</Discovery></Domain></CycloneDDS>',
        'ZENOH_CONFIG_OVERRIDE': f'transport/link/tx/lease={lease_s * 1000:.0f}',
    }
