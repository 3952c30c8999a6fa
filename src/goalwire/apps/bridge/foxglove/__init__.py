"""Foxglove's protocol of web sockets, version 1: messages travel as CDR, and need no decoding here."""
