"""Writes bags in children that are killed at random points, and prints what each kill cost, as JSON.

python kills.py FOLDER COUNT SEED: a child writes through an Intake as the recorder does, until it is killed.
"""

import json
import os
import random
import shutil
import signal
import sys
import time
from pathlib import Path

from rosbags.rosbag2 import Reader as TheirReader

from goalwire.apps.bag.intake import Intake
from goalwire.apps.bag.repeats import Repeats
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer
from goalwire.transport.contract import Sample


def write_until_killed(folder, size, pause, ready):
    bag = Writer(folder)
    bag.add_topic('/numbers', 'std_msgs/msg/Int32')
    intake = Intake(bag, 2**26, Repeats({}), failed=lambda _: os._exit(1))
    os.write(ready, b'.')
    number = 0
    while True:
        number += 1
        payload = b'\0\1\0\0' + number.to_bytes(4, 'little') + bytes(size)
        intake.put('/numbers', Sample(payload, number, 0, 0, b'g' * 16), time.time_ns())
        time.sleep(pause)


def kill_one(folder, choice):
    size, pause = choice.choice([(0, 0.001), (1000, 0.0005), (100_000, 0.004)])
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        write_until_killed(str(folder), size, pause, writing)
    os.read(reading, 1)
    time.sleep(choice.uniform(0.0, 1.5))
    killed = time.time_ns()
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(reading)
    os.close(writing)
    with Reader(folder) as bag:
        messages = [(m.time, int.from_bytes(m.data[4:8], 'little')) for m in bag.messages()]
        is_whole = not bag.problems
    numbers = [number for _, number in messages]
    try:
        with TheirReader(folder) as bag:
            others = sum(1 for _ in bag.messages())
    except Exception as error:
        others = repr(error)
    return {
        'gapless': numbers == list(range(1, len(numbers) + 1)),
        'lost_s': (killed - messages[-1][0]) / 1e9 if messages else None,
        'whole': is_whole,
        'messages': len(numbers),
        'rosbags': others,
    }


folder, count, choice = Path(sys.argv[1]), int(sys.argv[2]), random.Random(int(sys.argv[3]))
for number in range(count):
    print(json.dumps(kill_one(folder / str(number), choice)), flush=True)
    shutil.rmtree(folder / str(number))
