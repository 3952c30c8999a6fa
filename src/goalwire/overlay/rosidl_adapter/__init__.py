"""rosidl_adapter: only its parser, for tools that import it. Goalwire needs no conversion to IDL."""
