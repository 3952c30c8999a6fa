"""Coordinate frames: a tree of transforms over time. This package does no I/O, and has no messages and
threads.
"""
