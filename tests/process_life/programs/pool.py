"""`with Pool(2)` ends, idle or busy: its workers, forked after init, end by SIGTERM."""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import time

import rclpy
from forked import LIMIT_S, expect

faulthandler.dump_traceback_later(LIMIT_S, exit=True)
rclpy.init()
node = rclpy.create_node('pool')
begun, begin = os.pipe()


def work() -> None:
    os.write(begin, b'x')
    time.sleep(3600)


with multiprocessing.get_context('fork').Pool(2) as pool:
    expect('results', pool.map(abs, [-1, 2, -3]), [1, 2, 3])
with multiprocessing.get_context('fork').Pool(2) as pool:
    pool.apply_async(work)
    os.read(begun, 1)
expect('ok', rclpy.ok(), True)
node.destroy_node()
rclpy.shutdown()
print('good')
