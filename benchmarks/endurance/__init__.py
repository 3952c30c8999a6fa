"""Counts what very many calls, nodes, links and publishers leave behind, and times large messages."""
