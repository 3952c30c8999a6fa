"""usage: python -m benchmarks.soak [--minutes 60] [--transport zenoh|dds|memory] [--kill-every 10]

Eight processes: servers, clients and commanders of both fronts. They call services, send goals, cancel, give
up, publish; some are killed (kill -9) and restarted all the time. Commanders get SIGTERM, and try to go on.
At the end sent must be answered + failed, every failure of a documented kind, nothing handled twice, nothing
heard that was sent after SIGTERM, the survivors no larger than before. Exit code 0 if so, or 1.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import socket
import sys
import tempfile
from contextlib import suppress
from time import monotonic, strftime

from benchmarks.soak.conductor import Conductor
from benchmarks.soak.health import Health, worse

TRANSPORTS = {'zenoh': 'rmw_zenoh_cpp', 'dds': 'rmw_cyclonedds_cpp', 'memory': 'goalwire_memory'}
SAMPLES = 24
CALM_S = 12.0
"""Between the last kill and the end: DDS learns of a dead peer when its lease is over, after 10 s."""


def environment(transport: str, log_folder: str) -> dict[str, str]:
    """Return what keeps this run's graph to itself."""
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    return {
        'RMW_IMPLEMENTATION': TRANSPORTS[transport],
        'ROS_DOMAIN_ID': str(100 + os.getpid() % 100),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'GOALWIRE_ROUTER_PORT': str(port),
        'GOALWIRE_ROUTER': 'on',
        'ROS_LOG_DIR': log_folder,
    }


def print_sample(conductor: Conductor, seconds: float, held: dict[str, Health]) -> None:
    """Print one line of the course of things."""
    answered, failed = conductor.tally.ended
    sent = sum(conductor.tally.sent.values())
    parts = [
        f'{name} {h.rss_kib / 1024:.1f} MiB {h.threads} thr {h.descriptors} fd' for name, h in held.items()
    ]
    print(
        f'{seconds / 60:6.1f} min  sent {sent}, answered {answered}, failed {failed}, under way '
        f'{len(conductor.tally.open)}, kills {conductor.kills}, SIGTERMs {conductor.terminations}  |  '
        + '; '.join(parts),
        flush=True,
    )


def print_books(conductor: Conductor) -> None:
    """Print what was sent and what came of it."""
    tally = conductor.tally
    print(f'\n{"":28}{"sent":>9}{"answered":>10}{"failed":>9}')
    for title, sent, answered, failures in tally.rows():
        kinds = ', '.join(f'{n} {kind}' for kind, n in failures.items())
        print(f'{title:28}{sent:9}{answered:10}{sum(failures.values()):9}  {kinds}')
    answered, failed = tally.ended
    print(f'{"all":28}{sum(tally.sent.values()):9}{answered:10}{failed:9}')
    print(f'kills: {conductor.kills}; at most {tally.late_ms} ms after a deadline')
    heard = ', '.join(f'{n} {kind}s' for kind, n in sorted(tally.commanded.items()))
    tried = ', '.join(f'{n} {kind}s' for kind, n in sorted(tally.tried.items()))
    print(f'commanders: ended {conductor.terminations} times by SIGTERM; heard before: {heard}')
    print(f'            tried after it, and refused: {tried}')
    print('messages: {} heard, {} missed, {} disordered'.format(*tally.heard))
    print('feedback of reached goals: {} in time, {} missed'.format(*tally.feedback))


async def run(conductor: Conductor, minutes: float) -> int:
    """Run the whole, print, and return the exit code."""
    print(strftime('%Y-%m-%d %H:%M:%S'), f'{minutes:g} minutes', flush=True)
    try:
        await conductor.start()
        begun, seconds = monotonic(), minutes * 60
        killing = asyncio.ensure_future(conductor.kill_and_restart())
        for number in range(1, SAMPLES + 1):
            await asyncio.sleep(begun + seconds * number / SAMPLES - monotonic())
            print_sample(conductor, monotonic() - begun, conductor.sample())
            if killing.done():
                break
        killing.cancel()
        with suppress(asyncio.CancelledError):
            conductor.tally.problems += await killing
        await asyncio.sleep(CALM_S)
        await conductor.stop()
    finally:
        conductor.abandon()
    print_books(conductor)
    problems = conductor.tally.close()
    for name, samples in conductor.samples.items():
        problems += worse(name, samples)
    for problem in problems[:100]:
        print('PROBLEM', problem)
    print(strftime('%Y-%m-%d %H:%M:%S'), f'{len(problems)} problems' if problems else 'all is well')
    return bool(problems)


def main() -> None:
    """Take the arguments, and exit with the verdict."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.soak', description=__doc__)
    parser.add_argument('--minutes', type=float, default=60.0)
    parser.add_argument('--transport', choices=TRANSPORTS, default='zenoh')
    parser.add_argument('--kill-every', type=float, default=10.0, metavar='SECONDS')
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        conductor = Conductor(
            environment(options.transport, folder),
            one_process=options.transport == 'memory',
            kill_every=options.kill_every,
        )
        sys.exit(asyncio.run(run(conductor, options.minutes)))


if __name__ == '__main__':
    main()
