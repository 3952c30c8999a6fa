"""ROS 2 on DDS by libddsc, the library of Eclipse Cyclone DDS, opened through ctypes."""
