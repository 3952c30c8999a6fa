"""Takes from a program on POSIX what Windows lacks, before anything else is imported.

Python imports it at its start if this folder is on PYTHONPATH. Then there are no sockets of the file system,
no fork, no signals but those of C, no /proc and none of the modules below, and `sys.platform` is 'win32'.
Python's own library keeps what it needs of them: its modules that choose by the system are imported first.
`os.name` stays 'posix', since paths depend on it, so process groups and owners of files are there.
"""

import asyncio
import concurrent.futures.thread  # noqa: F401
import ctypes.util  # noqa: F401
import importlib
import logging  # noqa: F401
import multiprocessing  # noqa: F401
import os
import random  # noqa: F401
import select
import selectors
import shutil  # noqa: F401
import signal
import socket
import subprocess
import sys
import tempfile  # noqa: F401
import threading  # noqa: F401
import uuid  # noqa: F401
from typing import Any, NoReturn

MODULES = ('fcntl', 'grp', 'pty', 'pwd', 'resource', 'termios', 'tty')
OF_OS = (
    'eventfd', 'eventfd_read', 'eventfd_write', 'fork', 'forkpty', 'memfd_create', 'mkfifo', 'pidfd_open',
    'pipe2', 'register_at_fork', 'sched_getaffinity', 'sched_setaffinity', 'sched_yield', 'set_blocking',
)  # fmt: skip
OF_SOCKETS = (
    'AF_UNIX', 'CMSG_LEN', 'CMSG_SPACE', 'MSG_DONTWAIT', 'MSG_NOSIGNAL', 'SCM_RIGHTS', 'SO_REUSEPORT',
    'fromfd', 'recv_fds', 'send_fds',
)  # fmt: skip
KEPT_SIGNALS = {'SIGABRT', 'SIGFPE', 'SIGILL', 'SIGINT', 'SIGSEGV', 'SIGTERM'}
OF_SIGNALS = ('pthread_kill', 'pthread_sigmask', 'setitimer', 'siginterrupt', 'sigpending', 'sigwait')


def remove(module: Any, names: tuple[str, ...]) -> None:
    """Take names from a module, if it has them."""
    for name in names:
        if hasattr(module, name):
            delattr(module, name)


def connect_pair(*_arguments: int) -> tuple[socket.socket, socket.socket]:
    """Return a pair of sockets as Python makes it on Windows: two ends of a connection on this machine."""
    with socket.create_server(('127.0.0.1', 0)) as server:
        near = socket.create_connection(server.getsockname())
        far, _ = server.accept()
        return near, far


def refuse_proc(event: str, arguments: tuple[Any, ...]) -> None:
    """Raise FileNotFoundError if the program looks into /proc or /sys."""
    if event in {'open', 'os.listdir', 'os.scandir'} and str(arguments[0]).startswith(('/proc/', '/sys/')):
        raise FileNotFoundError(2, 'No such file or directory', str(arguments[0]))


def find_nothing(_socket: socket.socket) -> NoReturn:
    """Raise what a missing method raises."""
    raise AttributeError


def refuse_handler(*_arguments: Any) -> NoReturn:
    """Raise what the loops of Windows raise."""
    raise NotImplementedError


def install_descriptor(fd: int, **options: Any) -> int:
    """Do what `signal.set_wakeup_fd` does; on Windows the descriptor may be one that blocks."""
    if fd >= 0:
        set_blocking(fd, False)
    return set_wakeup_fd(fd, **options)


def kill(process: 'subprocess.Popen[Any]') -> None:
    """End a program by the number of SIGKILL, which has no name any more."""
    process.send_signal(9)


set_blocking, set_wakeup_fd = os.set_blocking, signal.set_wakeup_fd
for name in MODULES:
    sys.modules[name] = None  # type: ignore[assignment]  # an import of it raises ImportError
remove(os, OF_OS)
if hasattr(os, 'process_cpu_count'):
    os.process_cpu_count = os.cpu_count
remove(socket, OF_SOCKETS)
remove(sys.modules['_socket'], OF_SOCKETS)
remove(select, ('epoll', 'poll'))
remove(signal, tuple(name for name in dir(signal) if name.startswith('SIG') and name[3:4].isalpha() and
                     name not in KEPT_SIGNALS and not name.startswith('SIG_')))  # fmt: skip
remove(signal, OF_SIGNALS)
importlib.reload(selectors)
REPLACED: tuple[tuple[Any, str, object], ...] = (
    (signal, 'set_wakeup_fd', install_descriptor),
    (socket, 'socketpair', connect_pair),
    (socket.socket, 'recvmsg', property(find_nothing)),
    (socket.socket, 'recvmsg_into', property(find_nothing)),
    (socket.socket, 'sendmsg', property(find_nothing)),
    (subprocess.Popen, 'kill', kill),
    (asyncio.SelectorEventLoop, 'add_signal_handler', refuse_handler),
)
for owner, name, value in REPLACED:
    setattr(owner, name, value)
sys.addaudithook(refuse_proc)
sys.platform = 'win32'
