"""Builds the site from docs/, docstrings and the parsers of the command line: python -m tools.site."""
