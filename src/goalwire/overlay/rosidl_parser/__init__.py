"""The part of rosidl_parser that message classes show in SLOT_TYPES: rosidl_parser.definition."""
