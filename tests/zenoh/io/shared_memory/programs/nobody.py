"""Makes a program of root's one of another user's, who may lock little memory."""

import os
import resource

NOBODY = 65534


def become_nobody(lockable: int) -> None:
    """Become the user `nobody`, who may lock `lockable` KiB in memory, and has no right to more."""
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (lockable << 10, lockable << 10))
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)
