"""Small programs of well-known ROS 2 packages, for launch files and tutorials that use them.

Each package has a folder in `goalwire/prefix/share` with a setup.cfg, which maps each program to a function
here. A package of the same name that is installed or sourced comes first.
"""
