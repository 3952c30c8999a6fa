"""Commands that serve the graph to web sockets."""
