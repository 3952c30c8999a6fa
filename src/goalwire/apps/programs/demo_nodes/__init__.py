"""The demo nodes of ROS 2's tutorials: packages `demo_nodes_py` and `demo_nodes_cpp`.

Both packages have the same topics and services. The C++ programs count from 1, and their log texts differ.
"""
