"""The rendezvous, in a process that is not measured."""

from __future__ import annotations

import os

from benchmarks import stage
from goalwire.transport.zenoh.router import router


def answer() -> None:
    port = int(os.environ['GOALWIRE_ROUTER_PORT'])
    with router(port, [f'tcp/127.0.0.1:{port}'], []):
        stage.obey({})


if __name__ == '__main__':
    stage.run(lambda _: {}, answer)
