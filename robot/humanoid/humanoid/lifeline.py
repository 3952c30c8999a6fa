"""A child's tie to the process that started it: a pipe that closes when that process is gone."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import MutableMapping

VARIABLE = 'HUMANOID_LIFELINE'  # environment variable: tells a child to end when its standard input closes
GRACE = 3.0  # s between SIGTERM to this process and its forced exit


def hold(environment: MutableMapping[str, str]) -> None:
    """If the parent asked for it, start a thread that ends this process when standard input closes."""
    if environment.pop(VARIABLE, None):
        threading.Thread(target=_watch, name='lifeline', daemon=True).start()


def _watch() -> None:
    while os.read(0, 1024):
        pass
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(GRACE)
    os._exit(1)
