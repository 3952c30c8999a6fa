"""What is left behind after very many calls, nodes, links and publishers, and how large messages fare."""
