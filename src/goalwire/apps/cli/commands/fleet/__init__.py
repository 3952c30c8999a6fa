"""goalwire fleet and its verbs."""
