"""goalwire course: exercises on services and actions, and their checks."""
