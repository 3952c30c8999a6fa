"""goalwire secure: each verb has a module here."""
