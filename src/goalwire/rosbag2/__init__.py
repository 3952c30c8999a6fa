"""Bags as rosbag2 has them.

Files of MCAP or sqlite3, and the `metadata.yaml` beside them. No node, no wire.
"""
