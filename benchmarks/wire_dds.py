"""The floor on DDS: libddsc between two processes, with goalwire's domain configuration, none of its threads.

Each side waits in a waitset of its own on its only thread, takes what is there and answers, decoding nothing.
`python -m benchmarks.wire_dds serve` answers; `round_trip N SIZE` and `rate N SIZE` measure and print JSON.
Both ends are in the domain that ROS_DOMAIN_ID names.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes import byref, c_ssize_t, c_uint32, c_uint64, c_void_p, string_at
from pathlib import Path
from time import perf_counter

from goalwire.rules.qos import HistoryPolicy, QoS
from goalwire.transport.dds.abi import ANY_STATE, INFINITY, SERIALIZED_DATA, Library, Piece, SampleInfo
from goalwire.transport.dds.configuration import domain_configuration
from goalwire.transport.dds.description import endpoint_qos
from goalwire.transport.dds.library import find_library
from goalwire.transport.dds.status import PUBLICATION_MATCHED, SUBSCRIPTION_MATCHED
from goalwire.transport.dds.wire import OutPiece, Participant, Reader, Writer

SMALL = 80
"""Bytes of a message by default: 64 and a service header."""
WARM_UP = 200
PATIENCE_NS = 20_000_000_000
_TYPE = 'goalwire::msg::dds_::Raw_'
_AT_ONCE = 32
_HEADER = b'\0\1\0\0'


class End:
    """A participant that writes one topic and reads another."""

    def __init__(self, writes: str, reads: str) -> None:
        self.library = library = Library(find_library())
        domain_id = int(os.environ.get('ROS_DOMAIN_ID', '0'))
        self._domain = library.dds_create_domain(domain_id, domain_configuration(domain_id).encode())
        self._participant = participant = Participant(library, domain_id, b'')
        with endpoint_qos(library, QoS(history=HistoryPolicy.KEEP_ALL), b'') as qos:
            self.writer = Writer(participant, writes, _TYPE, qos)
            self.reader = Reader(participant, reads, _TYPE, qos)
        self._type = self.writer.serdata_type
        self._waitset = library.dds_create_waitset(participant.handle)
        library.dds_waitset_attach(self._waitset, self.reader.condition, 1)
        self._samples, self._infos = (c_void_p * _AT_ONCE)(), (SampleInfo * _AT_ONCE)()
        self._triggered, self._piece = (c_ssize_t * 1)(), Piece()

    def meet(self) -> None:
        """Wait until somebody reads what this writes, and writes what this reads."""
        library = self.library
        for entity, status, matched in (
            (self.writer.handle, PUBLICATION_MATCHED, library.dds_get_matched_subscriptions),
            (self.reader.handle, SUBSCRIPTION_MATCHED, library.dds_get_matched_publications),
        ):
            library.dds_set_status_mask(entity, status)
            waitset = library.dds_create_waitset(self._participant.handle)
            library.dds_waitset_attach(waitset, entity, 1)
            while matched(entity, (c_uint64 * 1)(), 1) < 1:
                if library.dds_waitset_wait(waitset, self._triggered, 1, PATIENCE_NS) <= 0:
                    sys.exit('the other end was not found')
                library.dds_take_status(entity, byref(c_uint32()), status)
            library.dds_delete(waitset)

    def write(self, message: bytes) -> None:
        """Send one message; its length is a multiple of four."""
        library, size = self.library, len(message)
        made = library.ddsi_serdata_from_ser_iov(
            self._type, SERIALIZED_DATA, 1, byref(OutPiece(message, size)), size
        )
        library.dds_writecdr(self.writer.handle, made)

    def take(self, patience_ns: int) -> list[bytes]:
        """Wait for messages and take up to 32; none where they take too long."""
        library = self.library
        if library.dds_waitset_wait(self._waitset, self._triggered, 1, patience_ns) <= 0:
            return []
        count = library.dds_takecdr(self.reader.handle, self._samples, _AT_ONCE, self._infos, ANY_STATE)
        return [self._content(self._samples[index] or 0, self._infos[index]) for index in range(count)]

    def _content(self, sample: int, info: SampleInfo) -> bytes:
        library, piece, content = self.library, self._piece, b''
        if info.valid_data:
            size = library.ddsi_serdata_size(sample)
            held = library.ddsi_serdata_to_ser_ref(sample, 0, size, byref(piece))
            content = string_at(piece.base, size)
            library.ddsi_serdata_to_ser_unref(held, byref(piece))
        library.ddsi_serdata_unref(sample)
        return content

    def close(self) -> None:
        """Leave the domain."""
        self.library.dds_delete(self._domain)


def serve() -> None:
    """Send every message back until the other end has gone."""
    end = End('rt/raw_pong', 'rt/raw_ping')
    end.meet()
    print('ready', flush=True)
    while True:
        for message in end.take(INFINITY):
            if not message:
                end.close()
                return
            end.write(message)


def receive(expected: int) -> None:
    """Take `expected` messages; print the seconds from the first to the last."""
    end = End('rt/raw_done', 'rt/raw_stream')
    end.meet()
    print('ready', flush=True)
    messages = [message for message in end.take(PATIENCE_NS) if message]
    begun, arrived = perf_counter(), len(messages)
    while arrived < expected:
        messages = end.take(PATIENCE_NS)
        if not messages:
            sys.exit(f'{expected - arrived} messages did not come')
        arrived += len([message for message in messages if message])
    print(json.dumps(perf_counter() - begun), flush=True)
    end.close()


def raw_round_trip(n: int, size: int = SMALL) -> list[float]:
    """Return the times of `n` messages of `size` bytes come back, one after the other, in seconds."""
    times: list[float] = json.loads(_measured('round_trip', n, size))
    return times


def raw_rate(n: int, size: int) -> float:
    """Return how many messages of `size` bytes a second arrive of `n` that are sent as fast as they go."""
    return (n - 1) / float(_measured('rate', n, size))


def _measured(what: str, n: int, size: int) -> str:
    """Measure in a process of its own: this one's threads stay out of it."""
    command = [sys.executable, '-m', 'benchmarks.wire_dds', what, str(n), str(size)]
    root = Path(__file__).resolve().parents[1]
    return subprocess.run(
        command, cwd=root, check=True, stdout=subprocess.PIPE, text=True, timeout=300
    ).stdout


@contextmanager
def _peer(*arguments: str) -> Iterator[Callable[[], str]]:
    """Run the other end; what it yields reads its next line."""
    command = [sys.executable, '-m', 'benchmarks.wire_dds', *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield process.stdout.readline


def _print_round_trips(n: int, message: bytes) -> None:
    with _peer('serve') as line:
        end = End('rt/raw_ping', 'rt/raw_pong')
        end.meet()
        line()
        times = []
        for _ in range(WARM_UP + n):
            start = perf_counter()
            end.write(message)
            if not end.take(PATIENCE_NS):
                sys.exit('the raw echo did not come')
            times.append(perf_counter() - start)
        end.close()
    print(json.dumps(times[WARM_UP:]))


def _print_rate(n: int, message: bytes) -> None:
    with _peer('receive', str(n)) as line:
        end = End('rt/raw_stream', 'rt/raw_done')
        end.meet()
        line()
        for _ in range(n):
            end.write(message)
        print(line(), end='')
        end.close()


if __name__ == '__main__':
    what, *numbers = sys.argv[1:]
    if what == 'serve':
        serve()
    elif what == 'receive':
        receive(int(numbers[0]))
    else:
        payload = _HEADER + bytes(int(numbers[1]) - len(_HEADER))
        {'round_trip': _print_round_trips, 'rate': _print_rate}[what](int(numbers[0]), payload)
