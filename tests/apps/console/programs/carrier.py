"""Missions that wait for people: `asks` for an approval, `paused` for somebody who resumes it.

Argument: the file of their journal. Each of their ends is printed.
"""

import asyncio
import sys

import goalwire
from goalwire.missions import MissionState, Runner, mission


@mission(resume='auto')
async def carry(m):
    return await m.approve('carry 7 kg?')


@mission(resume='auto')
async def wait(m):
    await m.sleep(3600)


async def main():
    async with goalwire.Node('carrier') as node, Runner(node, sys.argv[1], missions=[carry, wait]) as runner:
        asks = await runner.start(carry, id='asks')
        paused = await runner.start(wait, id='paused')
        await runner.pause('paused')
        await asks.until(MissionState.APPROVAL)
        await paused.until(MissionState.PAUSED)
        print('ready', flush=True)
        for run in (paused, asks):
            await run.ended.wait()
            told = [entry.body['who'] for entry in run.entries() if 'who' in entry.body]
            print(run.row.id, run.state, run.why, *told, flush=True)


asyncio.run(main())
