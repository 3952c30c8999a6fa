"""Bags as Parquet and as pictures. The command `bag export` itself writes CSV and JSON lines."""
