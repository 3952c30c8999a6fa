"""A program with a wake-up descriptor of its own, installed before init, hears of signals before and after.

Usage: wakeup_descriptor.py CLOSES

CLOSES `yes`: the program closes its descriptor, and has its number for a socket of other data. `no`: it does
not.
"""

from __future__ import annotations

import os
import signal
import socket
import sys

import rclpy

reader, writer = socket.socketpair()
writer.setblocking(False)
reader.settimeout(20)
number = writer.fileno()
signal.signal(signal.SIGUSR1, lambda *_: None)
signal.set_wakeup_fd(number)


def heard() -> list[int]:
    """Send this process a signal; return what its descriptor says of it."""
    os.kill(os.getpid(), signal.SIGUSR1)
    return list(reader.recv(64))


print('before init:', heard())
rclpy.init()
node = rclpy.create_node('wakeup_descriptor')
print('after init:', heard())
if sys.argv[1] == 'no':
    rclpy.shutdown()
    print('after shutdown:', heard())
    print('its place:', signal.set_wakeup_fd(-1) == number)
else:
    reader.close()
    writer.close()
    ours, theirs = socket.socketpair()
    ours, theirs = sorted((ours, theirs), key=lambda end: end.fileno() != number)
    print('the number is used again:', ours.fileno() == number)
    os.kill(os.getpid(), signal.SIGUSR1)
    rclpy.shutdown()
    os.kill(os.getpid(), signal.SIGUSR1)
    ours.send(b'data')
    print('strangers get:', theirs.recv(64).decode())
    print('its place:', signal.set_wakeup_fd(-1))
