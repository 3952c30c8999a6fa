"""Plain Zenoh sessions of either make, with one face, so that each scenario runs between any two of them."""

from __future__ import annotations

import json
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import zenoh
from helpers.isolation import free_port
from helpers.patience import PATIENCE, wait_for

from goalwire.transport.zenoh import threads
from goalwire.zenoh.io.dialler import Retry
from goalwire.zenoh.io.endpoints import TlsFiles
from goalwire.zenoh.io.native_session import NativeSession
from goalwire.zenoh.io.settings import MemorySettings, Settings
from goalwire.zenoh.protocol.bodies import Consolidation, Sample
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.network import ReplyError, Target
from goalwire.zenoh.protocol.publication import Publication
from goalwire.zenoh.protocol.querier import Querier

TLS_NAMES = (
    'root_ca_certificate',
    'listen_certificate',
    'listen_private_key',
    'connect_certificate',
    'connect_private_key',
    'enable_mtls',
    'verify_name_on_connect',
)
NO_FILES = TlsFiles()
BYTES_ONLY = MemorySettings()
ROLES = {'peer': Role.PEER, 'client': Role.CLIENT, 'router': Role.ROUTER}


class Heard:
    """The samples that came, as (key, payload); the payload is None for deletions."""

    def __init__(self) -> None:
        self.samples: list[tuple[str, bytes | None]] = []

    def __call__(self, key: str, payload: bytes | None) -> None:
        self.samples.append((key, payload))

    def wait(self, count: int) -> list[tuple[str, bytes | None]]:
        wait_for(lambda: len(self.samples) >= count, f'{count} samples, have {len(self.samples)}')
        return self.samples


class Answers:
    """The answers to one query, errors as ('error', text), and whether it has ended."""

    def __init__(self) -> None:
        self.answers: list[tuple[str, bytes]] = []
        self.ended = threading.Event()

    def wait(self) -> list[tuple[str, bytes]]:
        assert self.ended.wait(PATIENCE), 'the query did not end'
        return self.answers


class Side(ABC):
    """One session."""

    make: str
    id: str
    held: list[Any]
    """Queries that are not answered."""

    @abstractmethod
    def subscribe(self, key: str) -> Heard: ...
    @abstractmethod
    def put(self, key: str, payload: bytes, *, droppable: bool = False) -> None: ...
    @abstractmethod
    def serve(self, key: str, answer: bytes | None, *, error: bytes = b'', complete: bool = True) -> None: ...
    @abstractmethod
    def ask(
        self, key: str, payload: bytes = b'', timeout_s: float = 10.0, *, latest: bool = False
    ) -> Answers: ...
    @abstractmethod
    def present(self, key: str) -> set[str]: ...
    @abstractmethod
    def token(self, key: str) -> Callable[[], object]: ...
    @abstractmethod
    def watch(self, key: str) -> Heard: ...
    @abstractmethod
    def links(self) -> set[str]: ...
    @abstractmethod
    def close(self) -> None: ...


class Ours(Side):
    """A session of goalwire's own."""

    make = 'ours'

    def __init__(
        self,
        mode: str = 'peer',
        listen: tuple[str, ...] = (),
        connect: tuple[str, ...] = (),
        lease_ms: int = 60_000,
        zid: str = '',
        *,
        tls: TlsFiles = NO_FILES,
        portable: bool = False,
        memory: MemorySettings = BYTES_ONLY,
    ) -> None:
        self.session = NativeSession(
            Settings(
                tls=tls,
                role=ROLES[mode],
                listen=listen,
                connect=connect,
                lease_ms=lease_ms,
                zid=bytes.fromhex(zid)[::-1],
                retry=Retry(0.05, 0.2),
                portable=portable,
                memory=memory,
            )
        )
        self.protocol = self.session.protocol
        self.id = self.session.id
        self.held = []
        self._publications: dict[tuple[str, bool], Publication] = {}

    def subscribe(self, key: str) -> Heard:
        heard = Heard()

        def take(sample: Sample) -> None:
            heard(sample.key, None if sample.payload is None else bytes(sample.payload))

        self.protocol.declare_subscriber(key, take)
        return heard

    def put(self, key: str, payload: bytes, *, droppable: bool = False) -> None:
        publication = self._publications.get((key, droppable))
        if publication is None:
            publication = Publication(self.protocol, key, droppable=droppable)
            self._publications[key, droppable] = publication
        publication.put(payload)

    def serve(self, key: str, answer: bytes | None, *, error: bytes = b'', complete: bool = True) -> None:
        def take(query: Query) -> None:
            if answer is not None:
                query.answer(key, answer + bytes(query.payload or b''))
            elif error:
                query.reply_error(error)
                query.end()
            else:
                self.held.append(query)

        self.protocol.declare_queryable(key, take, complete=complete)

    def ask(
        self, key: str, payload: bytes = b'', timeout_s: float = 10.0, *, latest: bool = False
    ) -> Answers:
        answers = Answers()

        def take(answer: Sample | ReplyError) -> None:
            if isinstance(answer, Sample):
                answers.answers.append((answer.key, bytes(answer.payload or b'')))
            else:
                answers.answers.append(('error', answer.payload))

        consolidation = Consolidation.LATEST if latest else Consolidation.NONE
        querier = Querier(self.protocol, key, target=Target.ALL_COMPLETE, consolidation=consolidation)
        querier.ask(payload, None, take, answers.ended.set, timeout_s)
        return answers

    def present(self, key: str) -> set[str]:
        return set(self.protocol.tokens(key))

    def token(self, key: str) -> Callable[[], object]:
        number = self.protocol.declare_token(key)
        return lambda: self.protocol.undeclare(number)

    def watch(self, key: str) -> Heard:
        heard = Heard()

        def take(sample: Sample) -> None:
            heard(sample.key, None if sample.payload is None else b'')

        self.protocol.watch_tokens(key, take, history=True)
        return heard

    def links(self) -> set[str]:
        from goalwire.zenoh.protocol.primitives import show_id

        return {show_id(link.zid) for link in self.protocol.links if link.peer.knows_all}

    def close(self) -> None:
        self.session.close()


class Portable(Ours):
    """The same without what only Linux has."""

    make = 'portable'

    def __init__(self, mode: str = 'peer', **options: object) -> None:
        super().__init__(mode, portable=True, **options)  # type: ignore[arg-type]


class Theirs(Side):
    """A session of eclipse-zenoh."""

    make = 'theirs'

    def __init__(
        self,
        mode: str = 'peer',
        listen: tuple[str, ...] = (),
        connect: tuple[str, ...] = (),
        lease_ms: int = 60_000,
        zid: str = '',
        strategy: str = 'greater-zid',
        *,
        tls: TlsFiles = NO_FILES,
        numbers: str = '32bit',
        shares_memory: bool = False,
    ) -> None:
        config = zenoh.Config()
        values: dict[str, object] = {
            'mode': mode,
            'listen/endpoints': list(listen),
            'connect/endpoints': list(connect),
            'connect/retry': {'period_init_ms': 50, 'period_max_ms': 200, 'period_increase_factor': 2},
            'scouting/multicast/enabled': False,
            'scouting/delay': 20,
            'scouting/gossip/target': {'router': ['router', 'peer'], 'peer': ['router']},
            'scouting/gossip/autoconnect_strategy': {'peer': {'to_router': 'always', 'to_peer': strategy}},
            'timestamping/enabled': True,
            'transport/link/tx/lease': lease_ms,
            'transport/link/tx/sequence_number_resolution': numbers,
            'transport/shared_memory/enabled': shares_memory,
            'transport/link/tls': {
                name: None if getattr(tls, name) == '' else getattr(tls, name) for name in TLS_NAMES
            },
        }
        if zid:
            values['id'] = zid
        for name, value in values.items():
            config.insert_json5(name, json.dumps(value))
        self.session = threads.open_session(config)
        self.id = str(self.session.zid())
        self.held = []
        self._kept: list[object] = []

    def _direct(self, function: Callable[..., None], drop: Callable[[], None] = lambda: None) -> Any:
        return zenoh.handlers.Callback(function, drop=drop, indirect=False)

    def subscribe(self, key: str) -> Heard:
        heard = Heard()

        def take(sample: zenoh.Sample) -> None:
            is_put = sample.kind == zenoh.SampleKind.PUT
            heard(str(sample.key_expr), sample.payload.to_bytes() if is_put else None)

        self._kept.append(self.session.declare_subscriber(key, self._direct(take)))
        return heard

    def put(self, key: str, payload: bytes, *, droppable: bool = False) -> None:
        control = zenoh.CongestionControl.DROP if droppable else zenoh.CongestionControl.BLOCK
        self.session.put(key, payload, congestion_control=control)

    def serve(self, key: str, answer: bytes | None, *, error: bytes = b'', complete: bool = True) -> None:
        def take(query: zenoh.Query) -> None:
            if answer is not None:
                asked = b'' if query.payload is None else query.payload.to_bytes()
                query.reply(key, answer + asked)
            elif error:
                query.reply_err(error)
            else:
                self.held.append(query)
                return
            query.drop()  # type: ignore[no-untyped-call]

        self._kept.append(self.session.declare_queryable(key, self._direct(take), complete=complete))

    def ask(
        self, key: str, payload: bytes = b'', timeout_s: float = 10.0, *, latest: bool = False
    ) -> Answers:
        answers = Answers()

        def take(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                answers.answers.append((str(reply.ok.key_expr), reply.ok.payload.to_bytes()))
            elif reply.err is not None:
                answers.answers.append(('error', reply.err.payload.to_bytes()))

        self.session.get(
            key,
            self._direct(take, answers.ended.set),
            payload=payload,
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.LATEST if latest else zenoh.ConsolidationMode.NONE,
            timeout=timeout_s,
        )
        return answers

    def present(self, key: str) -> set[str]:
        answers: set[str] = set()
        ended = threading.Event()

        def take(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                answers.add(str(reply.ok.key_expr))

        self.session.liveliness().get(key, self._direct(take, ended.set), timeout=PATIENCE)
        assert ended.wait(PATIENCE), 'the query did not end'
        return answers

    def token(self, key: str) -> Callable[[], object]:
        token = self.session.liveliness().declare_token(key)
        self._kept.append(token)
        return token.undeclare

    def watch(self, key: str) -> Heard:
        heard = Heard()

        def take(sample: zenoh.Sample) -> None:
            heard(str(sample.key_expr), b'' if sample.kind == zenoh.SampleKind.PUT else None)

        self._kept.append(self.session.liveliness().declare_subscriber(key, self._direct(take), history=True))
        return heard

    def links(self) -> set[str]:
        info = self.session.info
        return {str(zid) for zid in [*info.peers_zid(), *info.routers_zid()]}

    def close(self) -> None:
        self.session.close()  # type: ignore[no-untyped-call]


def address(protocol: str = 'tcp') -> str:
    """Return where a session may listen."""
    return f'{protocol}/127.0.0.1:{free_port()}'
