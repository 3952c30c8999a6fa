"""The rules of durable missions, pure: a journal goes in, decisions come out. No file, no wire, no clock."""
