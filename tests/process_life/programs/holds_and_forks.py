"""Holds the rendezvous, forks a child that lives on, and ends: after a line, or by being killed."""

from __future__ import annotations

import os
import signal
import sys

import rclpy

rclpy.init()
node = rclpy.create_node('holder')
child_is_ready, ready = os.pipe()
child = os.fork()
if child == 0:
    os.setsid()
    nowhere = os.open(os.devnull, os.O_RDWR)
    for each in (0, 1, 2):  # whoever reads what the holder writes sees its end
        os.dup2(nowhere, each)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.write(ready, b'x')
    while True:
        signal.pause()
os.read(child_is_ready, 1)
print('ready', child, flush=True)
sys.stdin.readline()
node.destroy_node()
rclpy.shutdown()
