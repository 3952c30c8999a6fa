"""The services by which players and recorders pause and resume. Their names are rosbag2's."""

from __future__ import annotations

from collections.abc import Callable

from rosbag2_interfaces.srv import IsPaused, Pause, Resume, TogglePaused

import goalwire


def offer_pausing(
    node: goalwire.Node, is_paused: Callable[[], bool], set_paused: Callable[[bool], object]
) -> None:
    """Serve ~/pause, ~/resume, ~/toggle_paused and ~/is_paused."""

    def pause(_request: Pause.Request) -> Pause.Response:
        set_paused(True)
        return Pause.Response()

    def resume(_request: Resume.Request) -> Resume.Response:
        set_paused(False)
        return Resume.Response()

    def toggle(_request: TogglePaused.Request) -> TogglePaused.Response:
        set_paused(not is_paused())
        return TogglePaused.Response()

    def tell(_request: IsPaused.Request) -> IsPaused.Response:
        return IsPaused.Response(paused=is_paused())

    node.service(Pause, '~/pause', pause)
    node.service(Resume, '~/resume', resume)
    node.service(TogglePaused, '~/toggle_paused', toggle)
    node.service(IsPaused, '~/is_paused', tell)
