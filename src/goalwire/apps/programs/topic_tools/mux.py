"""mux: republishes the selected one of several topics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from rclpy.node import Node
from topic_tools_interfaces.srv import MuxAdd, MuxDelete, MuxList, MuxSelect

from goalwire.apps.programs.running import UsageError, spin_with_words
from goalwire.apps.programs.topic_tools.passing import Input, Output

NONE = '__none'
"""The selected name if no input is selected."""


class Mux(Node):
    """Republishes the messages of the selected input; services `~/select`, `~/add`, `~/delete`, `~/list`."""

    def __init__(self, target: str, sources: list[str]) -> None:
        super().__init__('mux')
        self._output = Output(self, target)
        self._inputs: dict[str, Input] = {}
        for source in sources:
            self._listen(self.resolve_topic_name(source))
        self._selected = next(iter(self._inputs))
        self.create_service(MuxSelect, '~/select', self._select)
        self.create_service(MuxAdd, '~/add', self._add)
        self.create_service(MuxDelete, '~/delete', self._delete)
        self.create_service(MuxList, '~/list', self._list)

    def _listen(self, topic: str) -> None:
        self._inputs[topic] = Input(self, topic, self._output.open, self._taker(topic))

    def _taker(self, topic: str) -> Callable[[bytes], None]:
        return partial(self._take, topic)

    def _take(self, topic: str, serialized: bytes) -> None:
        if topic == self._selected:
            self._output.send(serialized)

    def _select(self, request: MuxSelect.Request, response: MuxSelect.Response) -> MuxSelect.Response:
        response.prev_topic = self._selected
        topic = request.topic if request.topic == NONE else self.resolve_topic_name(request.topic)
        response.success = topic == NONE or topic in self._inputs
        if response.success:
            self._selected = topic
        else:
            self.get_logger().warning(f'{topic} is not an input: {", ".join(self._inputs)}')
        return response

    def _add(self, request: MuxAdd.Request, response: MuxAdd.Response) -> MuxAdd.Response:
        topic = self.resolve_topic_name(request.topic)
        response.success = topic not in self._inputs
        if response.success:
            self._listen(topic)
        return response

    def _delete(self, request: MuxDelete.Request, response: MuxDelete.Response) -> MuxDelete.Response:
        topic = self.resolve_topic_name(request.topic)
        response.success = topic in self._inputs and topic != self._selected
        if response.success:
            self._inputs.pop(topic).close()
        return response

    def _list(self, _request: MuxList.Request, response: MuxList.Response) -> MuxList.Response:
        response.topics = list(self._inputs)
        return response


def main(argv: Sequence[str] | None = None) -> int:
    """Run mux."""
    return spin_with_words('mux', 'OUTPUT INPUT [INPUT ...]', _make, argv)


def _make(words: list[str]) -> Node:
    if len(words) < 2:
        raise UsageError('it needs an output and at least one input')
    return Mux(words[0], words[1:])
