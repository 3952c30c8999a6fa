"""Free descriptors are counted before they are needed; sockets of C's libraries stay in their process."""

from __future__ import annotations

import os
import socket
import sys

import pytest

from goalwire.concurrency.descriptors import LibrarysSockets, require_free
from goalwire.errors import TransportError

if sys.platform != 'win32':
    import resource

needs_posix = pytest.mark.skipif(sys.platform == 'win32', reason='limits and inodes of POSIX')


def test_enough_are_free() -> None:
    require_free('a thing', 8)


@needs_posix
def test_too_few_are_told_with_what_is_left_and_the_limit() -> None:
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    highest = max(int(each) for each in os.listdir('/dev/fd'))  # noqa: PTH208 - numbers are wanted
    fillers = [os.open(os.devnull, os.O_RDONLY)]
    while fillers[-1] < highest:
        fillers.append(os.dup(fillers[0]))
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (fillers[-1] + 6, limits[1]))
        with pytest.raises(
            TransportError, match=rf'^a thing needs 8 .* only 5 are left.* limit of {fillers[-1] + 6}'
        ):
            require_free('a thing', 8)
        require_free('a thing', 5)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
        for each in fillers:
            os.close(each)


def _open_inheritable() -> int:
    """Open a socket as a library of C's does."""
    with socket.socket() as opened:
        number = os.dup(opened.fileno())
    os.set_inheritable(number, True)
    return number


@needs_posix
def test_sockets_that_are_opened_in_the_block_are_closed_by_exec_and_in_children() -> None:
    with socket.socket() as before:
        before.set_inheritable(True)
        with LibrarysSockets() as sockets:
            number = _open_inheritable()
        assert not os.get_inheritable(number)
        sockets.reset_in_child()
        with pytest.raises(OSError, match='Bad file'):
            os.fstat(number)
        os.fstat(before.fileno())
        assert before.get_inheritable()


@needs_posix
def test_a_number_that_is_another_files_by_now_stays_open() -> None:
    with LibrarysSockets() as sockets:
        number = _open_inheritable()
    os.close(number)
    with open(os.devnull, 'rb') as file:  # noqa: PTH123
        os.dup2(file.fileno(), number)
    sockets.reset_in_child()
    os.close(number)
