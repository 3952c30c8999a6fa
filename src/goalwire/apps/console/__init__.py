"""`goalwire console`: any ROS 2 robot in the browser. See docs/how-to/console.md.

Modules here know no browser; those of the folder `page` show what these hold.
"""
