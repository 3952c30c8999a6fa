"""Who holds the port of the rendezvous: a Zenoh router, or a program that will never answer as one.

Zenoh itself waits for the answer of a program that accepts and says nothing for as long as `open_timeout`, a
minute, and a session that does so closes only by a limit of 10 s (1.10.2). So a holder is greeted before.
"""

from __future__ import annotations

import os
from contextlib import suppress
from enum import Enum
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

PATIENCE_S = 2.0
"""How long a holder may take to answer. A router of a busy machine takes some milliseconds."""

_INIT = bytes.fromhex('1900c109f1') + os.urandom(15) + b'\x01' + bytes.fromhex('0ac8ff812701')
"""The first batch of a Zenoh connection: its length, INIT of a peer with an id of 16 bytes, sizes, offers."""

_ID = 0x1F
_INIT_ID, _CLOSE_ID = 0x01, 0x03
_LISTENS = '0A'
"""TCP_LISTEN in /proc/net/tcp."""


class Holder(Enum):
    """What answers at a port of this machine."""

    NOBODY = 'nobody listens there'
    ZENOH = 'speaks Zenoh'
    MUTE = 'accepts connections and says nothing'
    STRANGER = 'does not speak Zenoh'


def look(port: int, patience: float = PATIENCE_S) -> Holder:
    """Greet whoever listens on a TCP port of this machine, as a Zenoh session does."""
    import _socket  # as in rendezvous.py: `socket` itself may not be imported while Ctrl-C ends the program

    greeter = _socket.socket(_socket.AF_INET, _socket.SOCK_STREAM)
    try:
        greeter.settimeout(patience)
        greeter.connect(('127.0.0.1', port))
        greeter.send(_INIT)
        answer, end = b'', monotonic() + patience
        while len(answer) < 3:
            greeter.settimeout(max(end - monotonic(), 0.001))
            piece = greeter.recv(3 - len(answer))
            if not piece:
                return Holder.STRANGER
            answer += piece
    except TimeoutError:
        return Holder.MUTE
    except ConnectionRefusedError:
        return Holder.NOBODY
    except OSError:  # it hung up
        return Holder.STRANGER
    finally:
        greeter.close()
    return Holder.ZENOH if answer[2] & _ID in {_INIT_ID, _CLOSE_ID} else Holder.STRANGER


def name_of_holder(port: int) -> str:
    """Return the command and number of the process that listens on a TCP port, as far as Linux tells."""
    from pathlib import Path  # costs 5 ms, and is needed only when something is broken

    sockets = {f'socket:[{inode}]' for inode in _inodes(port)}
    with suppress(OSError):
        for process in Path('/proc').iterdir():
            if sockets and process.name.isdigit() and _has_open(process, sockets):
                command = (
                    process.joinpath('cmdline').read_bytes().replace(b'\0', b' ').decode(errors='replace')
                )
                return f"'{_printable(command.strip())}' (process {process.name})"
    return 'another program'


def _printable(command: str) -> str:
    return ''.join(sign if sign.isprintable() else '?' for sign in command)[:120]


def _inodes(port: int) -> list[str]:
    found = []
    for table in ('tcp', 'tcp6'):
        with suppress(OSError), open(f'/proc/net/{table}', encoding='ascii') as lines:  # noqa: PTH123
            for line in list(lines)[1:]:
                fields = line.split()
                if fields[3] == _LISTENS and int(fields[1].rpartition(':')[2], 16) == port:
                    found.append(fields[9])
    return found


def _has_open(process: Path, sockets: set[str]) -> bool:
    with suppress(OSError):  # it has gone, or is another user's
        return any(os.readlink(each) in sockets for each in process.joinpath('fd').iterdir())  # noqa: PTH115
    return False
