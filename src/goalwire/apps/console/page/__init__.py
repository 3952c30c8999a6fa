"""The page: shows the console's state in a browser. It needs the extra `goalwire[console]`."""
