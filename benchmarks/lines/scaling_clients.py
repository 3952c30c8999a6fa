"""Many clients of one node, each with one call on its way: for the curves."""

from __future__ import annotations

from benchmarks import stage
from benchmarks.line import Figures
from benchmarks.lines.service_in_flight import measure


def ask(count: int, clients: int) -> Figures:
    return measure(clients, clients, count)


if __name__ == '__main__':
    stage.run(ask, lambda: None)
