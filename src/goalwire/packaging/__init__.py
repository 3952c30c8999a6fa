"""What tools that pack programs need of goalwire."""
