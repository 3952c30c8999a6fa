"""Bags in rosbag2's formats: files, metadata, reading and writing.

A bag has files of MCAP or sqlite3, and a `metadata.yaml` beside them. This package opens no node and no
session.
"""
