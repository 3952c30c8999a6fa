"""The floor: raw zenoh between two processes, with goalwire's runtime settings and none of its code.

Two callbacks, a lock, 64 bytes and a 33-byte attachment. `python -m benchmarks.wire serve PORT` answers.
"""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import zenoh

PAYLOAD = bytes(64)
ATTACHMENT = bytes(33)
SERVICE, PING, PONG = 'raw/service', 'raw/ping', 'raw/pong'
WARM_UP = 200
PATIENCE_S = 20.0


AS_ZENOH_COMES = {'ZENOH_RUNTIME': '()', 'GOALWIRE_PIN_THREADS': '0'}
"""Environment for a raw program as anybody writes it: Zenoh's own thread pools, no pinned thread states."""


def raw_service_round_trip(n: int, *, tuned: bool = True) -> list[float]:
    """Return the times of `n` queries one after the other, in seconds; `tuned` as goalwire sets Zenoh up."""
    return _measure('service', n, tuned=tuned)


def raw_topic_round_trip(n: int, *, tuned: bool = True) -> list[float]:
    """Return the times of `n` messages sent and come back, in seconds; `tuned` as goalwire sets Zenoh up."""
    return _measure('topic', n, tuned=tuned)


def _measure(what: str, n: int, *, tuned: bool) -> list[float]:
    """Measure in a process of its own: this one's threads and settings stay out of it."""
    command = [sys.executable, '-m', 'benchmarks.wire', what, str(n)]
    root = Path(__file__).resolve().parents[1]
    env = os.environ if tuned else {**os.environ, **AS_ZENOH_COMES}
    done = subprocess.run(
        command, cwd=root, env=env, check=True, stdout=subprocess.PIPE, text=True, timeout=300
    )
    times: list[float] = json.loads(done.stdout)
    return times


def _open(listen: int | None = None, connect: int | None = None) -> zenoh.Session:
    from goalwire.transport.zenoh import lifecycle, settings

    lifecycle.start()
    import zenoh

    values = settings.session(connect or 0)
    values['connect'] = {
        'endpoints': [f'tcp/127.0.0.1:{connect}'] if connect else [],
        'timeout_ms': int(PATIENCE_S * 1000),  # open returns once connected
        'exit_on_failure': True,
    }
    values['listen'] = {'endpoints': [f'tcp/127.0.0.1:{listen}'] if listen else []}
    return zenoh.open(zenoh.Config.from_json5(json.dumps(values)))


def serve(port: int) -> None:
    """Answer until standard input ends."""
    import zenoh

    from goalwire.transport.zenoh.thread_state import pin

    session = _open(listen=port)
    pong = session.declare_publisher(PONG)

    def answer(query: zenoh.Query) -> None:
        pin()
        assert query.payload is not None
        assert query.attachment is not None
        query.reply(SERVICE, query.payload.to_bytes(), attachment=query.attachment.to_bytes())
        query.drop()  # type: ignore[no-untyped-call]

    def send_back(sample: zenoh.Sample) -> None:
        pin()
        assert sample.attachment is not None
        pong.put(sample.payload.to_bytes(), attachment=sample.attachment.to_bytes())

    direct = zenoh.handlers.Callback
    session.declare_queryable(SERVICE, direct(answer, indirect=False), complete=True)
    session.declare_subscriber(PING, direct(send_back, indirect=False))
    print('ready', flush=True)
    sys.stdin.read()
    session.close()  # type: ignore[no-untyped-call]


@contextmanager
def _server() -> Iterator[int]:
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        port: int = probe.getsockname()[1]
    command = [sys.executable, '-m', 'benchmarks.wire', 'serve', str(port)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=os.environ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        yield port
        assert process.stdin is not None
        process.stdin.close()


def _timed(exchange: Callable[[], None], n: int) -> list[float]:
    times = []
    for _ in range(WARM_UP + n):
        start = perf_counter()
        exchange()
        times.append(perf_counter() - start)
    return times[WARM_UP:]


def _service(session: zenoh.Session, done: Lock) -> Callable[[], None]:
    import zenoh

    from goalwire.transport.zenoh import client
    from goalwire.transport.zenoh.thread_state import pin

    querier = client.declare(session, SERVICE)

    def on_reply(reply: zenoh.Reply) -> None:
        pin()
        assert reply.ok is not None
        reply.ok.payload.to_bytes()
        done.release()

    def on_end() -> None:
        pin()

    def exchange() -> None:
        handler = zenoh.handlers.Callback(on_reply, drop=on_end, indirect=False)
        querier.get(handler, payload=PAYLOAD, attachment=ATTACHMENT)
        if not done.acquire(timeout=PATIENCE_S):
            sys.exit('the raw server did not answer')

    return exchange


def _topic(session: zenoh.Session, done: Lock) -> Callable[[], None]:
    import zenoh

    from goalwire.transport.zenoh.thread_state import pin

    ping = session.declare_publisher(PING)

    def on_pong(sample: zenoh.Sample) -> None:
        pin()
        sample.payload.to_bytes()
        done.release()

    session.declare_subscriber(PONG, zenoh.handlers.Callback(on_pong, indirect=False))

    def exchange() -> None:
        ping.put(PAYLOAD, attachment=ATTACHMENT)
        if not done.acquire(timeout=PATIENCE_S):
            sys.exit('the raw echo did not come')

    return exchange


def _print_times(what: str, n: int) -> None:
    with _server() as port:
        session = _open(connect=port)
        done = Lock()
        done.acquire()
        exchange = {'service': _service, 'topic': _topic}[what](session, done)
        _meet(session)
        print(json.dumps(_timed(exchange, n)))
        session.close()  # type: ignore[no-untyped-call]


def _meet(session: zenoh.Session) -> None:
    """Wait until the server sees what was declared here: it shows in a query that comes back after it."""
    replies = list(session.get(SERVICE, payload=PAYLOAD, attachment=ATTACHMENT))
    if not replies:
        sys.exit('the raw server was not found')


if __name__ == '__main__':
    if sys.argv[1] == 'serve':
        serve(int(sys.argv[2]))
    else:
        _print_times(sys.argv[1], int(sys.argv[2]))
