"""A child's tie to the process that started it: a pipe that closes when that process is gone."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import MutableMapping

VARIABLE = 'HUMANOID_LIFELINE'  # set for a child that ends when its standard input closes
GRACE = 3.0  # s between asking this process to stop and ending it


def hold(environment: MutableMapping[str, str]) -> None:
    """Watch standard input on a separate thread, if the process that started this one asked for it."""
    if environment.pop(VARIABLE, None):
        threading.Thread(target=_watch, name='lifeline', daemon=True).start()


def _watch() -> None:
    while os.read(0, 1024):
        pass
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(GRACE)
    os._exit(1)
