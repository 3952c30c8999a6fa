"""Records and plays bags, each with a node."""
