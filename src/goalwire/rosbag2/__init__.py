"""Bags in rosbag2's formats: files, metadata, reading and writing.

Files of MCAP or sqlite3, and the `metadata.yaml` beside them. No node, no wire.
"""
