"""Where the tested programs and their interfaces are; a project of yours has them installed."""

import os
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ('examples', 'examples/course', 'robot/humanoid')]
os.environ.setdefault('GOALWIRE_INTERFACE_PATH', str(ROOT / 'robot'))
