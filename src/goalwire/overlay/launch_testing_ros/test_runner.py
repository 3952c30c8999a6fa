"""launch_testing_ros.test_runner: the runner of launch_testing, under the name that programs import."""

from __future__ import annotations

from launch_testing import test_runner

__all__ = ['LaunchTestRunner']


class LaunchTestRunner(test_runner.LaunchTestRunner):
    """Runs each launch with its tests."""
