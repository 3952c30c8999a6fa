"""Where the programs are that are tested here; a project of yours has them installed."""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ('examples', 'examples/course', 'robot/humanoid')]
