"""`goalwire console`: any ROS 2 robot in the browser. See docs/how-to/console.md.

Only the modules in the folder `page` deal with browsers. They show the data of the other modules.
"""
