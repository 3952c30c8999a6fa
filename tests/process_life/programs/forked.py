"""Steps that programs of this folder share: fork, wait for a child for a bounded time, say what was seen."""

from __future__ import annotations

import faulthandler
import os
import select
import signal
import sys
from collections.abc import Callable

HUNG = 'still runs'
LIMIT_S = float(os.environ.get('LIMIT_S', '20'))


def end_of(child: int, seconds: float = LIMIT_S) -> int | str:
    """Wait for a child; return its exit code (negative: the signal). One that hangs is killed: HUNG."""
    descriptor = os.pidfd_open(child)
    try:
        has_ended = select.select([descriptor], [], [], seconds)[0]
    finally:
        os.close(descriptor)
    if not has_ended:
        os.kill(child, signal.SIGKILL)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return code if has_ended else HUNG


def in_child(body: Callable[[], object], seconds: float = LIMIT_S) -> int | str:
    """Run `body` in a forked child, which then ends by os._exit; return how it has ended."""
    child = os.fork()
    if child == 0:
        code = 70
        faulthandler.dump_traceback_later(seconds - 1)
        try:
            body()
            code = 0
        except BaseException as error:
            print(f'in the child: {type(error).__name__}: {error}', file=sys.stderr, flush=True)
        finally:
            os._exit(code)
    return end_of(child, seconds)


def is_open(descriptor: int) -> bool:
    """Whether a descriptor of this process is open."""
    try:
        os.fstat(descriptor)
    except OSError:
        return False
    return True


def expect(what: str, seen: object, wanted: object) -> None:
    """If something else was seen than wanted, print it and end the program."""
    if seen != wanted:
        print(f'{what}: {seen!r}, not {wanted!r}', flush=True)
        os._exit(1)
