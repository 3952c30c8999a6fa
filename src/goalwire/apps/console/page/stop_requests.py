"""STOP by plain requests, for pages whose web socket is lost, slow, or not there yet.

A page sends each press in both ways at once, by its web socket and by a request of this module. The console
does it once: both have the same id.
"""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import aclosing
from typing import Any

from fastapi import FastAPI, Request
from fastapi.responses import PlainTextResponse, Response, StreamingResponse

from goalwire.apps.console.entry import PRINCIPAL
from goalwire.apps.console.state.presses import MOST_LETTERS, Press
from goalwire.apps.console.state.session import Session
from goalwire.apps.console.state.stopping import Answer
from goalwire.records import record

PATH = '/console/stop'
_NO_STORE = {'Cache-Control': 'no-store'}


@record
class Pressed:
    """A press of STOP, as a browser describes it."""

    press: str
    """The press's id, which the browser has chosen."""
    robot: str
    """The namespace of the robot to stop."""
    is_for_all: bool
    """True if all robots are to be stopped."""


def read_press(values: Any) -> Pressed | None:
    """Return the press that a browser describes; None if it is not the description of one."""
    if not isinstance(values, dict):
        return None
    press, robot, is_for_all = values.get('press'), values.get('robot'), values.get('all')
    if not isinstance(press, str) or not 0 < len(press) <= MOST_LETTERS or not isinstance(robot, str):
        return None
    return Pressed(press, robot, is_for_all is True)


def describe_answer(press: str, answer: Answer) -> dict[str, Any]:
    """Return an answer as the browser reads it."""
    return {
        'press': press,
        'robot': answer.robot or '/',
        'service': answer.service,
        'text': answer.text,
        'ok': answer.is_done,
    }


def install_stop(application: FastAPI, session: Session) -> None:
    """Add the address to which browsers send STOP."""

    @application.post(PATH, include_in_schema=False)
    async def stop(request: Request) -> Response:
        """Stop, and send each answer as a line of JSON when it comes.

        With `again` in the body nothing is stopped: the answers of a known press are sent once more.
        """
        try:
            body = await request.json()
        except (ValueError, RecursionError):
            body = None
        pressed = read_press(body)
        if pressed is None:
            return PlainTextResponse('this is not a press of STOP\n', 400, _NO_STORE)
        if body.get('again') is True:
            press = session.presses.get(pressed.press)
            if press is None:
                return PlainTextResponse('the console has been started anew since\n', 404, _NO_STORE)
        else:
            rights = session.rights_of(request.scope.get('state', {}).get(PRINCIPAL))
            press = session.begin_stop(pressed.press, pressed.robot, rights, is_for_all=pressed.is_for_all)
        return StreamingResponse(
            _lines(pressed.press, press), media_type='application/x-ndjson', headers=_NO_STORE
        )


async def _lines(id_: str, press: Press) -> AsyncIterator[str]:
    yield '\n'  # the head of the answer leaves at once: the press has arrived
    async with aclosing(press.answers()) as answers:
        async for answer in answers:
            yield json.dumps(describe_answer(id_, answer)) + '\n'
