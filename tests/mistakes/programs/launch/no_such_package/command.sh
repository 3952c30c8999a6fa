# A launch file names a package that is not there.
# says: lamp.launch.xml:2: package 'demo_node_py' not found; did you mean demo_nodes_py or demo_nodes_cpp?
# at: lamp.launch.xml:2
ros2 launch lamp.launch.xml
