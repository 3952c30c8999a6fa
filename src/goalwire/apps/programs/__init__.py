"""The small programs that launch files and tutorials of ROS 2 name, under the names of their packages.

Each package has a folder in `goalwire/prefix/share`, whose setup.cfg says which function a program runs. A
package of the same name that is installed or sourced comes first.
"""
