"""Single keys of a terminal: a signal counts at once, and not only with the next key."""

from __future__ import annotations

import sys

from helpers.screens import CTRL_C, screen

ANOTHER_THREAD_GETS_IT = """
import signal
import threading
from goalwire.apps.programs.keyboard import interrupt_on_signals, keys

interrupt_on_signals()
threading.Thread(target=threading.Event().wait, daemon=True).start()
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
try:
    with keys() as pressed:
        print('ready', flush=True)
        for key in pressed:
            print('key', key, flush=True)
except KeyboardInterrupt:
    print('interrupted', flush=True)
"""


def test_ctrl_c_counts_although_it_interrupts_no_read(isolated: dict[str, str]) -> None:
    """A signal that comes just before a read does not interrupt it, nor does one that another thread gets."""
    with screen(isolated, '-c', ANOTHER_THREAD_GETS_IT, program=sys.executable) as terminal:
        terminal.expect('ready')
        terminal.press(b'i')
        terminal.expect('key i')
        terminal.press(CTRL_C)
        terminal.expect('interrupted')
        assert terminal.wait() == 0
