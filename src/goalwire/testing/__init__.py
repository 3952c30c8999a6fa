"""Tests without a robot."""
