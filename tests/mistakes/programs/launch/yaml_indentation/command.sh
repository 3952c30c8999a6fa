# A launch file in YAML is not indented as its other lines.
# says: lamp.launch.yaml:4: no valid YAML: expected <block end>, but found '-'; this line has 4 blanks before it, and line 2 has 2: give it as many if it belongs to the same list
# at: lamp.launch.yaml:4
ros2 launch lamp.launch.yaml
