"""The part of rosidl_parser that SLOT_TYPES of message classes use: rosidl_parser.definition."""
