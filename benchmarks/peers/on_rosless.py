"""The work that rosless can do, topics, on DDS by Rust: reads that wait.

usage: python -m benchmarks.peers.on_rosless ask topic COUNT | answer topic
"""

from __future__ import annotations

import itertools
import os
import sys
import threading
from typing import TYPE_CHECKING, Any

import rosless  # type: ignore[import-not-found]

from benchmarks import stage

if TYPE_CHECKING:
    from benchmarks.line import Figures

ME = 'benchmarks.peers.on_rosless'
POSE = 'geometry_msgs/msg/PoseStamped'
PING, PONG = '/bench_ping', '/bench_pong'
RELIABLE = {'reliability': 'reliable', 'durability': 'volatile', 'history': 'keep_last', 'depth': 10}
PATIENCE_S = 20.0


def new_node() -> Any:
    return rosless.Node(domain=int(os.environ['ROS_DOMAIN_ID']))


def answer(_work: str) -> None:
    """Send every message back until the asking process ends."""
    node = new_node()
    pong = node.advertise(PONG, POSE, **RELIABLE)
    pings = node.subscribe(PING, POSE, **RELIABLE)

    def send_back() -> None:
        for message in pings:
            pong.send(message)

    threading.Thread(target=send_back, daemon=True).start()
    stage.obey({})
    os._exit(0)


def ask(_work: str, count: int) -> Figures:
    """Measure topics there and back."""
    with stage.Partner(ME, 'topic') as partner:
        node = new_node()
        ping = node.advertise(PING, POSE, **RELIABLE)
        pongs = node.subscribe(PONG, POSE, **RELIABLE)
        while True:  # until both ends have found each other
            ping.send(rosless.Message(POSE))
            if pongs.read(timeout=0.1) is not None:
                break
        numbers = itertools.count()

        def exchange() -> None:
            sent = str(next(numbers))
            ping.send(rosless.Message(POSE, header={'frame_id': sent}))
            while (pong := pongs.read(timeout=PATIENCE_S)) is not None and pong.header.frame_id != sent:
                pass  # of the meeting
            if pong is None:
                sys.exit('a message did not come back')

        return stage.round_trips(exchange, count, partner)


if __name__ == '__main__':
    stage.run(ask, answer)
