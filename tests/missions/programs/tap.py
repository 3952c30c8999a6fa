"""Listens on the wire to the action `drive`, and writes down each goal that is sent to whatever server.

It is a second, silent queryable beside the server, so it gets every request and answers none of them.
"""

from __future__ import annotations

import itertools
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

from goalwire.rules.goals.wire import goal_id_of
from goalwire.transport import registry
from goalwire.transport.contract import SessionOptions
from goalwire.zenoh.protocol.incoming_queries import Query

DOMAIN = int(os.environ['ROS_DOMAIN_ID'])


def main(path: str) -> None:
    with Path(path).open('a', encoding='utf-8') as heard:
        number = itertools.count()

        def note(query: Query) -> None:
            print(
                goal_id_of(bytes(query.payload or b'')).hex(),
                next(number),
                time.monotonic(),
                file=heard,
                flush=True,
            )
            query.end()

        session: Any = registry.get('rmw_zenoh_cpp').open(SessionOptions(domain_id=DOMAIN))
        session._context.wire.declare_queryable(f'{DOMAIN}/drive/_action/send_goal/**', note)
        print('ready', flush=True)
        threading.Event().wait()


main(sys.argv[1])
