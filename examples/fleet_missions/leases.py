"""Which mission has which robot: one table in Postgres, beside the tables of the engine.

A row is a lease. Until the robot has been asked, it ends after LEASE_S seconds, if its worker has died. From
then on the robot may have begun, so the mission keeps the robot until its end is known.
"""

import asyncio

import psycopg

LEASE_S = 20.0

_TABLE = """
CREATE TABLE IF NOT EXISTS leases (
    mission text PRIMARY KEY,
    robot text NOT NULL,
    until timestamptz NOT NULL,
    asked boolean NOT NULL DEFAULT false,
    ended boolean NOT NULL DEFAULT false
);
CREATE UNIQUE INDEX IF NOT EXISTS one_mission_a_robot ON leases (robot) WHERE NOT ended;
"""
_OVER = 'DELETE FROM leases WHERE NOT asked AND NOT ended AND until < now()'
_RENEW = """
UPDATE leases SET until = CASE WHEN robot = ANY(%(robots)s) THEN now() + %(lease)s::interval ELSE until END
WHERE mission = %(mission)s RETURNING robot
"""
_TAKE = """
INSERT INTO leases (mission, robot, until)
SELECT %(mission)s, robot, now() + %(lease)s::interval
FROM unnest(%(robots)s::text[]) WITH ORDINALITY AS free (robot, place)
WHERE robot NOT IN (SELECT robot FROM leases WHERE NOT ended) ORDER BY place LIMIT 1
ON CONFLICT DO NOTHING RETURNING robot
"""
_ASK = """
UPDATE leases SET asked = true
WHERE mission = %(mission)s AND robot = %(robot)s AND (asked OR %(is_there)s) RETURNING robot
"""
_END = 'UPDATE leases SET ended = true WHERE mission = %s RETURNING robot'


class Leases:
    """The table. Every method may be called twice, and goes on trying while Postgres is away."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._connection: psycopg.AsyncConnection | None = None
        self._turn = asyncio.Lock()

    async def open(self) -> None:
        """Make the table. A lock keeps two workers from making it at once."""
        await self._do([('SELECT pg_advisory_xact_lock(32)', ()), (_TABLE, ())])

    async def take(self, mission: str, robots: list[str]) -> str | None:
        """Return the robot of this mission; if it has none, the first of these robots that is free."""
        values = {'mission': mission, 'robots': robots, 'lease': f'{LEASE_S} s'}
        row = await self._do([(_OVER, ()), (_RENEW, values)]) or await self._do([(_TAKE, values)])
        return row[0] if row else None

    async def ask(self, mission: str, robot: str, is_there: bool) -> bool:
        """Note that the robot is asked now, and return whether it may be asked.

        It may not if the lease has ended, or if the robot is away and was never asked: then another robot can
        have the mission.
        """
        values = {'mission': mission, 'robot': robot, 'is_there': is_there}
        return await self._do([(_ASK, values)]) is not None

    async def end(self, mission: str) -> None:
        """Note that the mission has ended: the robot is free."""
        await self._do([(_END, (mission,))])

    async def _do(self, statements):
        """Carry out one transaction, and return the first row of its last statement."""
        async with self._turn:
            while True:
                try:
                    if self._connection is None or self._connection.closed:
                        self._connection = await psycopg.AsyncConnection.connect(self._url)
                    async with self._connection.transaction():
                        for text, values in statements:
                            cursor = await self._connection.execute(text, values or None)
                    return await cursor.fetchone() if cursor.description else None
                except psycopg.OperationalError as error:
                    print(f'Postgres is away: {error}', flush=True)
                    if self._connection is not None:
                        await self._connection.close()
                    await asyncio.sleep(1.0)
