"""The console without its page: observes the robots and sends to them, for all browsers."""
