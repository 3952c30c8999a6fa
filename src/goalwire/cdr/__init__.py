"""Encodes messages as bytes (CDR) and hashes types (RIHS01)."""
