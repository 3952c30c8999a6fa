"""Recording and playing: bags with a node around them."""
