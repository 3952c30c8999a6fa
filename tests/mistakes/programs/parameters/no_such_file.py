# The parameter file is not there.
# arguments: --ros-args --params-file drivers.yaml
# says: Error opening YAML file: No such file or directory: correct the name, or give the whole path; the program looks in the folder in which it was started
import rclpy

rclpy.init()  # <-- here
