"""How a session of goalwire's own RTPS is set up: from variables and files to plain values.

findings   what a file sets, and what of it has no effect here
cyclone    CYCLONEDDS_URI
fast_dds   the XML profiles of Fast DDS
session    all of it together, as the RMW that is asked for would have it
"""
