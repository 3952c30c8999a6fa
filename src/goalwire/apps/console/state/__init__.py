"""The console without its page: it knows the robots and sends to them, for all browsers."""
