"""Starts programs in children that it forks: each is a process of its own, and modules are imported once.

Its arguments are a socket and the modules. The socket brings a line of JSON for each program, with the
descriptors of its standard streams and of a pipe; the answer is the process id, and the pipe brings the exit
code as `subprocess` has it. What a program sees is what `python FILE` or `python -c TEXT` gives it:
`__main__`, arguments, environment and working directory. A program may ask for programs of its own: the
server listens at an address that its process id names.
"""

from __future__ import annotations

import gc
import json
import os
import signal
import socket
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from selectors import EVENT_READ, DefaultSelector
from types import ModuleType
from typing import Any

PROGRAM = Path(__file__)


def address(server: int) -> str:
    """Return where the server with this process id listens."""
    return f'\0test-fork-server-{server}'


def run(request: dict[str, Any], streams: list[int]) -> None:
    """Become the program, in the child, and end as it ends."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for target, stream in enumerate(streams):
        os.dup2(stream, target)
        os.close(stream)
    os.environ.clear()
    os.environ.update(request['environment'])
    if os.environ.get('PYTHONUNBUFFERED'):
        for written in (sys.stdout, sys.stderr):
            # Lines go out whole, even if this server was started unbuffered and writes each piece of a print.
            written.reconfigure(line_buffering=True, write_through=False)  # type: ignore[union-attr]
    os.chdir(request['folder'])
    file, text = request['file'], request['text']
    sys.argv = [file or '-c', *request['arguments']]
    sys.path[0] = str(Path(request['folder'], file).parent) if file else ''
    main = sys.modules['__main__'] = ModuleType('__main__')
    if file:
        main.__file__ = str(Path(file).absolute())
        text = Path(file).read_text(encoding='utf-8')
    gc.enable()
    try:
        exec(compile(text, file or '<string>', 'exec'), main.__dict__)
    except SystemExit:
        raise
    except BaseException as error:
        trace = error.__traceback__
        own = error.with_traceback(trace and trace.tb_next)
        sys.last_value = own
        sys.excepthook(type(own), own, own.__traceback__)
        if isinstance(error, KeyboardInterrupt):
            sys.excepthook = lambda *_: None  # it has been printed
            raise  # an interpreter that this ends dies by SIGINT, for its parent to see
        raise SystemExit(1) from None


class _Server:
    """Forks for each request, and tells of each end."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(address(os.getpid()))
        self._listener.listen()
        self._selector = DefaultSelector()
        for watched in (channel, self._listener):
            self._selector.register(watched, EVENT_READ)

    def serve(self) -> None:
        """Return in the child, with its program at its end, and when the other end is closed."""
        while True:
            for key, _ in self._selector.select():
                if key.fileobj is self._listener:
                    self._selector.register(self._listener.accept()[0], EVENT_READ)
                elif not isinstance(key.fileobj, socket.socket):
                    self._tell_end(key.fd, *key.data)
                elif not self._start(key.fileobj):
                    return

    def _start(self, channel: socket.socket) -> bool:
        """Fork for a request; False in the child, and when the first channel is closed."""
        try:
            data, descriptors, _, _ = socket.recv_fds(channel, 1 << 18, 4)
        except ConnectionError:
            data = b''  # the program that asked before was killed
        if not data:
            if channel is self._channel:
                self._end_programs()
                return False
            self._selector.unregister(channel)
            channel.close()
            return True
        *streams, ended = descriptors
        child = os.fork()
        if child == 0:
            os.close(ended)
            self._close()
            run(json.loads(data), streams)
            return False
        for stream in streams:
            os.close(stream)
        self._selector.register(os.pidfd_open(child), EVENT_READ, (child, ended))
        with suppress(ConnectionError):  # the program that asked was killed; its child sees a closed input
            channel.sendall(f'{child}\n'.encode())
        return True

    def _close(self) -> None:
        """Close, in a child, what the server alone needs: a pipe that stays open here would never end."""
        for key in self._selector.get_map().values():
            if isinstance(key.fileobj, socket.socket):
                key.fileobj.close()
            else:
                os.close(key.fd)
                os.close(key.data[1])
        self._selector.close()

    def _end_programs(self) -> None:
        """Kill the programs that still run: if their tests were killed, nobody else would."""
        for key in self._selector.get_map().values():
            if not isinstance(key.fileobj, socket.socket):
                with suppress(ProcessLookupError):
                    os.killpg(key.data[0], signal.SIGKILL)
                with suppress(ProcessLookupError):
                    signal.pidfd_send_signal(key.fd, signal.SIGKILL)  # it may not lead its group yet

    def _tell_end(self, watched: int, child: int, ended: int) -> None:
        self._selector.unregister(watched)
        os.close(watched)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        with suppress(BrokenPipeError), os.fdopen(ended, 'w') as pipe:  # who asked may have ended before
            pipe.write(str(code))


def main(channel: int, modules: list[str]) -> None:
    """Import the modules, then serve."""
    for module in modules:
        import_module(module)
    gc.collect()
    gc.freeze()  # children would copy what they share, only to look for garbage
    _Server(socket.socket(fileno=channel)).serve()


if __name__ == '__main__':
    main(int(sys.argv[1]), sys.argv[2:])
