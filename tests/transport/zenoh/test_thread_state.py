"""Zenoh's threads keep their Python thread state; who runs on one already pays next to nothing."""

from __future__ import annotations

import sys
import threading
from types import FrameType

from helpers.wire import Answers

from goalwire.transport.contract import Request
from goalwire.transport.zenoh import threads
from goalwire.transport.zenoh.threads import keep_thread_state

from .conftest import OpenSide, on_eclipse


def test_only_the_first_call_on_a_thread_runs_python_code() -> None:
    entered: list[str] = []

    def note(frame: FrameType, event: str, argument: object) -> None:
        if event == 'call':
            entered.append(frame.f_code.co_filename)

    keep_thread_state()
    sys.setprofile(note)
    keep_thread_state()
    sys.setprofile(None)
    assert threads.__file__ not in entered


@on_eclipse
def test_what_is_local_to_a_thread_of_zenohs_is_there_the_next_time(open_side: OpenSide) -> None:
    """It goes with the thread's state: so that was kept."""
    ours, theirs, here = open_side('ours'), open_side('theirs'), threading.local()
    visits: list[tuple[int, int]] = []

    def visit(request: Request) -> None:
        here.count = getattr(here, 'count', 0) + 1
        visits.append((threading.get_ident(), here.count))
        request.reply(b'')

    theirs.service('/visit', visit)
    client = ours.client('/visit')
    ours.expect_server(client, '/visit')
    of_thread: dict[int, list[int]] = {}
    while not any(len(counts) > 1 for counts in of_thread.values()):  # Zenoh chooses among several threads
        answers = Answers()
        answers.ask(client)
        answers.expect(replies=1)
        of_thread.setdefault(visits[-1][0], []).append(visits[-1][1])
    assert threading.get_ident() not in of_thread
    assert all(counts == list(range(1, len(counts) + 1)) for counts in of_thread.values())
