"""rosidl_parser: only its module `definition`, whose types SLOT_TYPES of message classes contain."""
