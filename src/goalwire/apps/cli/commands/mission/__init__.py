"""goalwire mission."""
