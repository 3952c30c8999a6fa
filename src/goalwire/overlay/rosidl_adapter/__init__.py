"""rosidl_adapter: its parser, as tools import it; nothing is converted to IDL, since nothing is built."""
