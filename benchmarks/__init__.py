"""The benchmark suite; its harness uses the tests' helpers, its measured programs only rclpy."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / 'tests'))
