"""The page: what a browser is shown of the console's state. It needs the extra `goalwire[console]`."""
