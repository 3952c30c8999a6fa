"""Messages of any size from `publish` to the callback in another process: for the curves."""

from __future__ import annotations

from benchmarks import stage
from benchmarks.lines.image import measure

if __name__ == '__main__':
    stage.run(measure, lambda: None)
