# A launch file in Python is not indented as its other lines.
# says: lamp.launch.py:9: IndentationError: unindent does not match any outer indentation level; the line has 2 blanks before it, those above have 0 or 4 or 8: give it one of these
# at: lamp.launch.py:9
ros2 launch lamp.launch.py
