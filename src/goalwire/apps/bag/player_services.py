"""The services of a player's node; their names are rosbag2's."""

from __future__ import annotations

from rosbag2_interfaces.srv import Burst, GetRate, PlayNext, Seek, SetRate, Stop

from goalwire.apps.bag.pause_services import offer_pausing
from goalwire.apps.bag.player import Player
from goalwire.errors import BagError


def offer_services(player: Player) -> None:
    """Serve ~/pause, ~/resume, ~/toggle_paused, ~/seek, ~/set_rate, ~/play_next, ~/burst, ~/stop and more."""

    def get_rate(_request: GetRate.Request) -> GetRate.Response:
        return GetRate.Response(rate=player.rate)

    def set_rate(request: SetRate.Request) -> SetRate.Response:
        try:
            player.rate = request.rate
        except BagError:
            return SetRate.Response(success=False)
        return SetRate.Response(success=True)

    def play_next(_request: PlayNext.Request) -> PlayNext.Response:
        return PlayNext.Response(success=player.step())

    def burst(request: Burst.Request) -> Burst.Response:
        count = request.num_messages or sum(player.bag.counts.values())
        return Burst.Response(actually_burst=count if player.step(count) else 0)

    def seek(request: Seek.Request) -> Seek.Response:
        return Seek.Response(success=player.seek(request.time.sec * 1_000_000_000 + request.time.nanosec))

    def stop(_request: Stop.Request) -> Stop.Response:
        player.stop()
        return Stop.Response()

    node = player.node
    offer_pausing(node, lambda: player.paused, lambda paused: player.pause() if paused else player.resume())
    node.service(GetRate, '~/get_rate', get_rate)
    node.service(SetRate, '~/set_rate', set_rate)
    node.service(PlayNext, '~/play_next', play_next)
    node.service(Burst, '~/burst', burst)
    node.service(Seek, '~/seek', seek)
    node.service(Stop, '~/stop', stop)
