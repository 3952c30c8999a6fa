# A launch file in YAML is not indented as its other lines.
# says: lamp.launch.yaml:4: no valid YAML: expected <block end>, but found '-'; this line has 4 blanks before it, and what it may belong to begins in line 2 behind 4: indent both alike
# at: lamp.launch.yaml:4
ros2 launch lamp.launch.yaml
