"""Starts the members, kills and restarts some of them, and writes down what all of them tell."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from asyncio.subprocess import PIPE, Process
from contextlib import suppress
from itertools import count
from pathlib import Path
from random import Random

from benchmarks.soak.health import Health, health
from benchmarks.soak.member import CLIENTS, COMMANDERS, KILLED, SERVERS, SURVIVORS, WORLD
from benchmarks.soak.report import NUMBERS
from benchmarks.soak.tally import Tally

ROOT = Path(__file__).resolve().parents[2]
START_S = 120.0
"""The time in s that a member may take to start, on a machine that is busy."""
STOP_S = 30.0
"""The time in s that clients and servers may take to end."""


class Member:
    """One incarnation of a member, as a process."""

    def __init__(self, name: str, incarnation: int, process: Process, tally: Tally) -> None:
        self.name = name
        self.incarnation = incarnation
        self.process = process
        self.ready = asyncio.Event()
        self._tally = tally
        self._killed = False
        self._reading = asyncio.gather(self._read(), self._read_errors())

    async def _read(self) -> None:
        assert self.process.stdout is not None
        async for line in self.process.stdout:
            self._tally.take(line.decode().rstrip('\n'))
            self.ready.set()

    async def _read_errors(self) -> None:
        assert self.process.stderr is not None
        async for line in self.process.stderr:
            self._tally.problems.append(f'{self.name} printed: {line.decode().rstrip()}')

    async def ended(self) -> int:
        """Wait for the end of the process and of its output; return its exit code.

        A caller that gives up waiting does not end the reading, for which others wait.
        """
        await asyncio.shield(self._reading)
        return await self.process.wait()

    async def kill(self) -> bool:
        """kill -9; False if there was nothing to kill."""
        alive, self._killed = self.process.returncode is None, True
        if alive:
            self.process.kill()
        await self.ended()
        self._tally.cut_off(self.incarnation, NUMBERS)
        return alive

    async def stop(self) -> None:
        """Ask the member to end. If it does not end, or ends with an error, that is a problem."""
        if self._killed:
            await self.ended()
            return
        assert self.process.stdin is not None
        self.process.stdin.close()
        await self._end_well()

    async def terminate(self) -> bool:
        """SIGTERM, after which a commander ends well; False if there was nothing to end."""
        with suppress(TimeoutError):
            async with asyncio.timeout(START_S):
                await self.ready.wait()  # before that it has no handler
        alive = self.process.returncode is None
        if alive:
            self.process.send_signal(signal.SIGTERM)
        await self._end_well()
        return alive

    async def _end_well(self) -> None:
        try:
            async with asyncio.timeout(STOP_S):
                code = await self.ended()
        except TimeoutError:
            self._tally.problems.append(f'{self.name} did not end within {STOP_S} s')
            with suppress(ProcessLookupError):
                self.process.send_signal(signal.SIGKILL)
            await self.process.wait()
        else:
            if code:
                self._tally.problems.append(f'{self.name} ended with exit code {code}')


class Conductor:
    """Every member, and how often some were killed."""

    def __init__(self, environment: dict[str, str], *, one_process: bool, kill_every: float) -> None:
        self.tally = Tally(may_close=one_process)
        self.samples: dict[str, list[Health]] = {}
        self.kills = self.terminations = 0
        self._environment = {**os.environ, **environment}
        self._one_process = one_process
        self._kill_every = kill_every
        self._members: dict[str, Member] = {}
        self._incarnations = count(1)
        self._random = Random()

    async def start(self) -> None:
        """Start every member, servers first."""
        for name in (WORLD,) if self._one_process else (*SERVERS, *CLIENTS, *COMMANDERS):
            await self._start(name)
        for member in list(self._members.values()):
            async with asyncio.timeout(START_S):
                await member.ready.wait()
        self.samples = {name: [] for name in ((WORLD,) if self._one_process else SURVIVORS)}

    async def _start(self, name: str) -> None:
        incarnation = next(self._incarnations)
        number = str(self._kill_every if name == WORLD else incarnation)
        process = await asyncio.create_subprocess_exec(
            sys.executable, '-m', 'benchmarks.soak.member', name, number,
            stdin=PIPE, stdout=PIPE, stderr=PIPE, env=self._environment, cwd=ROOT,
        )  # fmt: skip
        self._members[name] = Member(name, incarnation, process, self.tally)

    async def kill_and_restart(self) -> list[str]:
        """Kill a mortal member, or end a commander, every now and then; start it again a little later.

        For ever, or until one is found dead already: returns what to say about that.
        """
        if self._one_process:
            await asyncio.Event().wait()  # there they leave by themselves
        while True:
            await asyncio.sleep(self._random.uniform(0.5, 1.5) * self._kill_every)
            name = self._random.choice((*KILLED, *COMMANDERS))
            member = self._members[name]
            if not await (member.terminate() if name in COMMANDERS else member.kill()):
                return [f'{name} has ended by itself']
            if name in COMMANDERS:
                self.terminations += 1
            else:
                self.kills += 1
            await asyncio.sleep(self._random.uniform(0.0, 1.5))
            await self._start(name)

    def sample(self) -> dict[str, Health]:
        """Look at the survivors; one that has ended is a problem."""
        found = {}
        for name, samples in self.samples.items():
            try:
                found[name] = health(self._members[name].process.pid)
            except FileNotFoundError:
                self.tally.problems.append(f'{name} has ended by itself')
            else:
                samples.append(found[name])
        return found

    async def stop(self) -> None:
        """End the load: the clients first, when their last calls have come to an end."""
        if not self._one_process:
            await asyncio.gather(*(self._members[name].terminate() for name in COMMANDERS))
            self.terminations += len(COMMANDERS)
        for names in ((WORLD,),) if self._one_process else (CLIENTS, SERVERS):
            await asyncio.gather(*(self._members[name].stop() for name in names))

    def abandon(self) -> None:
        """Kill whatever still runs."""
        for member in self._members.values():
            if member.process.returncode is None:
                with suppress(ProcessLookupError):
                    member.process.kill()
