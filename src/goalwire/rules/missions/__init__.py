"""The rules of durable missions, without files, wire or clock: they read a journal and return decisions."""
