"""Messages as bytes (CDR) and types as hashes (RIHS01)."""
