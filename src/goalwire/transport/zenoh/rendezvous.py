"""The embedded rendezvous: every process offers a router, so that nobody has to start one.

One process of a machine holds the port. The others keep trying to bind it, and one of them takes over when
the holder dies. Ordinary sessions, goalwire's and rmw_zenoh's, connect there, learn of each other and then
talk directly. The router's code is imported by the process that takes the port, and by no other.

The port may be held by a program that is not a router. Zenoh waits a minute (`open_timeout`) for the answer
of a program that accepts and says nothing, and such a session closes only after 10 s (1.10.2). So this module
first sends a greeting to the program on the port.
"""

from __future__ import annotations

import os
from contextlib import closing, suppress
from enum import Enum
from errno import EADDRINUSE
from threading import Event, Thread
from time import monotonic
from typing import TYPE_CHECKING

from goalwire.concurrency.forks import forks_wait, in_child, leak, open_privately
from goalwire.concurrency.sigpipe import NO_SIGPIPE
from goalwire.concurrency.threads import begin, join_begun
from goalwire.errors import ForkedError, TransportError
from goalwire.fault_reports import LOGGER
from goalwire.patterns import Pattern
from goalwire.transport.endpoint import Shared, close_at_exit

if TYPE_CHECKING:
    from pathlib import Path

    from goalwire.transport.zenoh.embedded_router import OpenRouter
    from goalwire.transport.zenoh.settings.values import Configuration

PATIENCE_S = 2.0
"""How long the program on the port may take to answer. A router on a busy machine takes milliseconds."""

_INIT = bytes.fromhex('1900c109f1') + os.urandom(15) + b'\x01' + bytes.fromhex('0ac8ff812701')
"""The first batch of a Zenoh connection: its length, INIT of a peer with an id of 16 bytes, sizes, offers."""

_CLIENT_HELLO = bytes.fromhex(
    '1603010058 01000054 0303'  # a record of a handshake, a ClientHello, TLS 1.2 as TLS 1.3 writes it
    f'{os.urandom(32).hex()} 00 000a 1301 1302 1303 c02b c02f 0100'  # five ciphers, no compression
    '0021 002b0005 0403040303'  # 33 bytes of extensions: TLS 1.3 or 1.2
    '000a0006 0004001d0017'  # the groups X25519 and P-256
    '000d0004 00020403'  # ECDSA on P-256
    '00330002 0000'  # no key yet: the server asks for one
)
"""The beginning of a TLS connection. It is written out, since `ssl` imports `socket`: see `is_taken`."""

_TLS_ANSWERS = {bytes((kind, 3, minor)) for kind in (0x15, 0x16) for minor in (1, 2, 3)}
"""How an alert and a handshake of TLS begin."""

_ID = 0x1F
_INIT_ID, _CLOSE_ID = 0x01, 0x03
_LISTENS = '0A'
"""The state TCP_LISTEN in /proc/net/tcp."""


class Holder(Enum):
    """The kinds of programs that may hold a port of this machine."""

    NOBODY = 'nobody listens there'
    ZENOH = 'speaks Zenoh'
    MUTE = 'accepts connections and says nothing'
    STRANGER = 'does not speak Zenoh'
    TLS = 'speaks TLS, while this program has no security'


def look(port: int, patience: float = PATIENCE_S) -> Holder:
    """Greet the program that listens on a TCP port of this machine, as a Zenoh session does.

    A program with TLS answers with an alert (eclipse-zenoh) or hangs up (goalwire). So a program that hangs
    up gets a greeting of TLS, too.
    """
    answer = _greet(port, _INIT, patience)
    if isinstance(answer, Holder):
        return answer
    if answer in _TLS_ANSWERS:  # tested first: the third byte of an alert looks like Zenoh's CLOSE
        return Holder.TLS
    if answer and answer[-1] & _ID in {_INIT_ID, _CLOSE_ID}:
        return Holder.ZENOH
    return Holder.TLS if _greet(port, _CLIENT_HELLO, patience) in _TLS_ANSWERS else Holder.STRANGER


def _greet(port: int, greeting: bytes, patience: float) -> bytes | Holder:
    """Return the first three bytes of the answer, b'' if there are fewer, or the kind of the mute program."""
    import _socket  # as in `is_taken`: `socket` must not be imported while Ctrl-C ends the program

    class Greeter(_socket.socket):
        """A socket that allows weak references."""

        __slots__ = ('__weakref__',)

    greeter = open_privately(lambda: Greeter(_socket.AF_INET, _socket.SOCK_STREAM))
    try:
        greeter.settimeout(patience)
        greeter.connect(('127.0.0.1', port))
        greeter.send(greeting, NO_SIGPIPE)
        answer, end = b'', monotonic() + patience
        while len(answer) < 3:
            greeter.settimeout(max(end - monotonic(), 0.001))
            piece = greeter.recv(3 - len(answer))
            if not piece:
                return b''
            answer += piece
    except TimeoutError:
        return Holder.MUTE
    except ConnectionRefusedError:
        return Holder.NOBODY
    except OSError:  # the other side hung up
        return b''
    finally:
        greeter.close()
    return answer


def name_of_holder(port: int) -> str:
    """Return the command and id of the process that listens on a TCP port, if Linux shows them."""
    from pathlib import Path  # imported here: takes 5 ms, and is needed only for a warning

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
    with suppress(OSError):  # the process has gone, or is another user's
        return any(os.readlink(each) in sockets for each in process.joinpath('fd').iterdir())  # noqa: PTH115
    return False


RETRY_S = 0.2
"""The seconds between two attempts to take the port; each costs 20 µs of CPU."""

HESITATION_S = 10.0
"""How long a port must be free before it is taken from a router that this program cannot connect to, since
one of the two has security and the other has none. Such a router may be starting anew, which takes seconds;
if it has gone for good, programs that cannot use it still find each other."""

_TCP = Pattern(r'(?:tcp|tls|ws)/(?:\[([^]"]+)\]|(localhost|[\d.]+)):(\d+)')
"""Matches host and port of zenoh's TCP endpoints, except host names that need a look-up."""


def is_taken(endpoints: str) -> bool:
    """Return whether a program listens at one of these TCP endpoints (a list as text)."""
    # `_socket` is the C part of `socket`. If `socket` were imported while Ctrl-C ends the program, Python
    # would forget the Ctrl-C (since `socket`'s namedtuples call `eval`), and the program would exit with 1.
    import _socket

    for bracketed, plain, port in _TCP.findall(endpoints):
        family = _socket.AF_INET6 if bracketed else _socket.AF_INET
        with forks_wait, closing(_socket.socket(family, _socket.SOCK_STREAM)) as probe:
            # Zenoh's sockets set this, too: connections that the last holder has left do not block the port.
            if os.name == 'posix':
                probe.setsockopt(_socket.SOL_SOCKET, _socket.SO_REUSEADDR, 1)
            try:
                probe.bind((bracketed or plain, int(port)))
            except OSError as error:
                if error.errno == EADDRINUSE:
                    return True
    return False


def _sockets_on(port: int) -> list[int]:
    """Return the descriptors of this process's TCP sockets whose local port is `port`."""
    import _socket  # as in `is_taken`

    internet = (_socket.AF_INET, _socket.AF_INET6)
    found = []
    for name in os.listdir('/dev/fd') if os.path.isdir('/dev/fd') else ():  # noqa: PTH112, PTH208
        descriptor = int(name)
        with suppress(OSError):  # the descriptor is not a socket, or belongs to the listing itself
            looked_at = _socket.socket(fileno=descriptor)
            try:
                is_tcp = looked_at.type == _socket.SOCK_STREAM and looked_at.family in internet
                if is_tcp and looked_at.getsockname()[1] == port:
                    found.append(descriptor)
            finally:
                looked_at.detach()
    return found


class EmbeddedRouter:
    """One router, from the first attempt to open it until `close`.

    A thread repeats the attempt. eclipse-zenoh could do so itself, but then its session closes only after a
    limit of 10 s, with an error (1.10.2; upstream pull request 2754). And each failed attempt leaks 20 KiB.
    So a plain socket first tests if the port is free.
    """

    def __init__(self, port: int, config: Configuration) -> None:
        self._port = port
        self._config = config
        self._endpoints = str(config.at('listen/endpoints'))
        self._router: OpenRouter | None = None
        self._may_hold = False
        """True if sockets of eclipse-zenoh may be open on the port: a forked child must close these.
        goalwire's own sockets close in a child by themselves."""
        self._closed = Event()
        self._hesitates = False
        self._thread: Thread | None = None
        if is_taken(self._endpoints) or not self._take_port():
            self._thread = Thread(target=self._retry, name=f'rendezvous {port}', daemon=True)
            begin(self._thread)

    @property
    def is_open(self) -> bool:
        """True once this process holds the port."""
        return self._router is not None

    def _take_port(self) -> bool:
        """Open the router; return False if the port is taken.

        Raises TransportError, and ForkedError if the parent of this process has used eclipse-zenoh.
        """
        from goalwire.errors import AddressTakenError
        from goalwire.transport.zenoh.embedded_router import open_router

        try:
            self._router = open_router(self._port, self._config, self._note_eclipse)
        except AddressTakenError:
            self._may_hold = False
            return False
        return True

    def _note_eclipse(self) -> None:
        self._may_hold = True

    def _retry(self) -> None:
        taken_at = monotonic()
        try:
            while not self._closed.wait(RETRY_S):
                if is_taken(self._endpoints):
                    taken_at = monotonic()
                elif self._hesitates and monotonic() < taken_at + HESITATION_S:
                    continue
                elif self._take_port():
                    return
        except ForkedError:
            return
        except TransportError as error:
            from goalwire.logging import get_logger  # imported here: needed only for a warning

            get_logger(LOGGER).warning(str(error))

    def hesitate(self) -> None:
        """Take the port only after it has been free for `HESITATION_S`."""
        self._hesitates = True

    def stand_back(self) -> None:
        """Stop waiting for the port. Any thread may call this; it takes no lock, not even one of zenoh."""
        self._closed.set()

    def close_sockets(self) -> None:
        """Close a forked child's copies of zenoh's sockets on the port.

        While one is open no other process can listen on the port, and the parent's peers do not notice the
        parent's end. A router's sockets are found by their local port, which no other socket here has.
        """
        if self._may_hold:
            for descriptor in _sockets_on(self._port):
                os.close(descriptor)

    def close(self) -> None:
        """Release the port; another process takes over."""
        self._closed.set()
        if self._thread is not None:
            join_begun(self._thread)
        if self._router is not None:
            try:
                self._router.close()
            except Exception as error:  # a ZError: zenoh stops waiting for its own closing after 10 s
                from goalwire.logging import get_logger

                get_logger(LOGGER).warning(f'the embedded Zenoh router did not close properly: {error}')


class Rendezvous:
    """This process's routers, one per port, each kept as long as a session uses it."""

    def __init__(self) -> None:
        in_child(self._leave_to_parent)  # called before the reset of `Shared`, which forgets the routers
        self._routers: Shared[int, EmbeddedRouter] = Shared(EmbeddedRouter.close)
        self._left: set[int] = set()

    def offer(self, port: int, config: Configuration) -> None:
        """Offer the rendezvous until `stop_offering` was called once for each `offer`. Raises TransportError.

        Does nothing if the port was left to another router, or in a forked child of a process that has used
        eclipse-zenoh, which cannot be started there.
        """
        if port in self._left and self._routers.get(port) is None:
            return
        try:
            self._routers.open(port, lambda: EmbeddedRouter(port, config))
        except ForkedError:
            return
        close_at_exit(self)

    def stop_offering(self, port: int) -> None:
        """End one session's offer. After the end of the last offer another process takes over."""
        self._routers.close(port)

    def close(self) -> None:
        """Close all routers, even those in use, since the interpreter is ending."""
        self._routers.close_all()

    def leave_to_other(self, port: int) -> None:
        """Never take the port from now on, since a router that does not belong to goalwire holds it.

        Otherwise that router could not start again after its end, and goalwire's router serves only this
        machine. Zenoh's threads call this, so it takes no lock: a thread that opens a router holds the lock
        and waits for zenoh's threads.
        """
        self._left.add(port)
        router = self._routers.get(port)
        if router is not None:
            router.stand_back()

    def hesitate(self, port: int) -> None:
        """Leave time for a router that has the port and starts anew, and that this program does not meet."""
        router = self._routers.get(port)
        if router is not None:
            router.hesitate()

    def is_left(self, port: int) -> bool:
        """Return whether a port was left to another router."""
        return port in self._left

    def holds(self, port: int) -> bool:
        """Return whether this process is the rendezvous on a port."""
        router = self._routers.get(port)
        return router is not None and router.is_open

    def _leave_to_parent(self) -> None:
        """Leak the parent's routers in a forked child, since to delete them there could block for ever."""
        for router in self._routers.things():
            leak(router)
            router.close_sockets()


RENDEZVOUS = Rendezvous()
