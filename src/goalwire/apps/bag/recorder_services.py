"""The services of a recorder's node, and its topic for new files of a bag; their names are rosbag2's."""

from __future__ import annotations

import asyncio

from rosbag2_interfaces.msg import WriteSplitEvent
from rosbag2_interfaces.srv import Snapshot, SplitBagfile, Stop

from goalwire.apps.bag.pause_services import offer_pausing
from goalwire.apps.bag.recorder import Recorder
from goalwire.errors import BagError

SPLIT_TOPIC = 'events/write_split'


def offer_services(recorder: Recorder) -> None:
    """Serve ~/pause, ~/resume, ~/toggle_paused, ~/is_paused, ~/snapshot, ~/split_bagfile and ~/stop."""
    node = recorder.node
    task = asyncio.current_task()

    async def snapshot(_request: Snapshot.Request) -> Snapshot.Response:
        try:
            count = await recorder.snapshot()
        except BagError as error:
            node.logger.warning(str(error))
            return Snapshot.Response(success=False)
        node.logger.info(f'{count:,} messages of the snapshot are written')
        return Snapshot.Response(success=True)

    async def split(_request: SplitBagfile.Request) -> SplitBagfile.Response:
        await recorder.split()
        return SplitBagfile.Response()

    def set_paused(paused: bool) -> None:
        recorder.paused = paused
        node.logger.info('paused' if paused else 'recording goes on')

    def stop(_request: Stop.Request) -> Stop.Response:
        if task is not None:
            asyncio.get_running_loop().call_soon(task.cancel)
        return Stop.Response()

    node.service(Snapshot, '~/snapshot', snapshot)
    node.service(SplitBagfile, '~/split_bagfile', split)
    offer_pausing(node, lambda: recorder.paused, set_paused)
    node.service(Stop, '~/stop', stop)
    _tell_of_splits(recorder)


def _tell_of_splits(recorder: Recorder) -> None:
    """Publish an event whenever the recorder closes one file and begins the next."""
    publisher = recorder.node.publisher(WriteSplitEvent, SPLIT_TOPIC)
    loop = asyncio.get_running_loop()
    name = recorder.node.name

    def publish(closed: str, opened: str) -> None:
        publisher.publish(WriteSplitEvent(closed_file=closed, opened_file=opened, node_name=name))

    def on_split(closed: str, opened: str) -> None:  # called on the recorder's writing thread
        loop.call_soon_threadsafe(publish, closed, opened)

    recorder.bag.on_split = on_split
