# The parameter file has no ros__parameters.
# arguments: --ros-args --params-file driver.yaml
# says: failed to initialize rcl: Couldn't parse params file: '--params-file driver.yaml'. Error: Cannot have a value before ros__parameters at line 2; write the line 'ros__parameters:' between the node's name and its parameters
import pathlib

import rclpy

pathlib.Path('driver.yaml').write_text('driver:\n  speed: 2.0\n')
rclpy.init()  # <-- here
