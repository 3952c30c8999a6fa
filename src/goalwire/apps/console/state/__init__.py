"""What the console knows and sends, for all browsers, without a page."""
