"""eclipse-zenoh that shares memory, a session or a router: eclipse_side.py ROLE MODE ADDRESS COUNT [LOCKABLE]

ROLE is `router`, `subscriber` or `publisher`; MODE `listen`, `connect`, or `client` of a router.
With LOCKABLE the user `nobody` runs it, who may lock so many KiB in memory.
"""

import json
import sys
import threading
import zlib
from random import Random

import zenoh
from nobody import become_nobody

SIZES = (10, 1000, 3000, 60_000, 200_000, 1_000_000)


def configure(role: str, mode: str, address: str) -> zenoh.Config:
    config = zenoh.Config()
    values = {
        'mode': 'router' if role == 'router' else 'client' if mode == 'client' else 'peer',
        'scouting/multicast/enabled': False,
        'listen/endpoints': [address] if mode == 'listen' else [],
        'connect/endpoints': [] if mode == 'listen' else [address],
        'transport/shared_memory/enabled': True,
        'transport/shared_memory/mode': 'init',
        'transport/shared_memory/transport_optimization': {
            'enabled': True,
            'pool_size': 48 << 20,
            'message_size_threshold': 1024,
        },
    }
    for name, value in values.items():
        config.insert_json5(name, json.dumps(value))
    return config


def receive(session: zenoh.Session, count: int) -> None:
    """Print how many messages came, whether each was whole and in its place, and how many were shared."""
    numbers: list[int] = []
    torn: list[int] = []
    shared: list[int] = []
    ended = threading.Event()

    def take(sample: zenoh.Sample) -> None:
        data = sample.payload.to_bytes()
        number = int.from_bytes(data[:4], 'little')
        if zlib.crc32(data[8:]) != int.from_bytes(data[4:8], 'little'):
            torn.append(number)
        if sample.payload.as_shm() is not None:
            shared.append(number)
        numbers.append(number)
        if number == count - 1:
            ended.set()

    subscriber = session.declare_subscriber('test/shared', take)
    print('ready', flush=True)
    ended.wait(300)
    print(
        f'received {len(numbers)} complete {numbers == list(range(count))} torn {len(torn)} '
        f'shared {len(shared) > 0}',
        flush=True,
    )
    subscriber.undeclare()  # type: ignore[no-untyped-call]


def send(session: zenoh.Session, count: int) -> None:
    publisher = session.declare_publisher('test/shared', congestion_control=zenoh.CongestionControl.BLOCK)
    matched = threading.Event()
    listener = publisher.declare_matching_listener(lambda status: matched.set() if status.matching else None)
    print('ready', flush=True)
    matched.wait(60)
    listener.undeclare()  # type: ignore[no-untyped-call]
    random = Random(count)
    for number in range(count):
        body = random.randbytes(random.choice(SIZES))
        publisher.put(number.to_bytes(4, 'little') + zlib.crc32(body).to_bytes(4, 'little') + body)
    print('sent', flush=True)


def main() -> None:
    role, mode, address, count, *options = sys.argv[1:]
    if options:
        become_nobody(int(options[0]))
    session = zenoh.open(configure(role, mode, address))
    if role == 'subscriber':
        receive(session, int(count))
    elif role == 'publisher':
        send(session, int(count))
    else:
        print('ready', flush=True)
    sys.stdin.readline()
    session.close()  # type: ignore[no-untyped-call]


main()
