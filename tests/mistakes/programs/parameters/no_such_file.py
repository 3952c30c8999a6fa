# The parameter file is not there.
# arguments: --ros-args --params-file drivers.yaml
# says: failed to initialize rcl: Couldn't parse params file: '--params-file drivers.yaml'. Error: Error opening YAML file: No such file or directory
import rclpy

rclpy.init()  # <-- here
