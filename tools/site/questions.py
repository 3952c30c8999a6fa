"""Thirty questions to the site's search, and the pages that answer them; a test asks them all."""

from __future__ import annotations

QUESTIONS = {
    'how do I cancel a goal': ['from-ros/cancel-a-goal', 'course/actions'],
    'service call hangs': ['from-ros/service-call-hangs'],
    'await in a callback': ['from-ros/await-in-a-callback'],
    'rclpy without ROS': ['from-ros/rclpy-without-ros'],
    'rosbridge': ['from-ros/from-rosbridge', 'how-to/bridges'],
    'windows macos': ['from-ros/macos-windows-colab'],
    'exercises': ['course/exercises'],
    'what is the difference between topics, services and actions': [
        'explanation/topics-services-actions',
        'course/topics-services-actions',
    ],
    'my first service': ['tutorials/first-service'],
    'my first action': ['tutorials/first-action'],
    'custom interfaces': ['how-to/interfaces'],
    'launch files': ['how-to/launch', 'reference/launch-files'],
    'record a bag': ['how-to/bags', 'commands/bag'],
    'jupyter notebook': ['how-to/notebooks'],
    'environment variables': ['reference/environment-variables'],
    'list of errors': ['reference/errors', 'api/goalwire.errors'],
    'deadlines and failures': ['how-to/deadlines-and-failures'],
    'how do I test without a robot': ['how-to/testing'],
    'virtual time': ['how-to/testing'],
    'asyncio API': ['how-to/asyncio-api'],
    'lifecycle nodes': ['how-to/lifecycle'],
    'security keys': ['how-to/security'],
    'connect to a real robot': ['how-to/real-robot'],
    'cyclone dds': ['how-to/dds'],
    'log levels': ['how-to/logging'],
    'performance benchmarks': ['reference/performance'],
    'reliability faults': ['reference/reliability'],
    'which thread runs my callback': ['explanation/execution'],
    'differences from rclpy': ['reference/differences-from-rclpy'],
    'glossary': ['explanation/glossary'],
}
