"""Coordinate frames: a tree of transforms over time. Pure: no I/O, no messages, no threads of its own."""
