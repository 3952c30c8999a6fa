"""The settings of a session of goalwire's own RTPS, read from variables and files.

findings   the settings in a file, and those without effect here
cyclone    CYCLONEDDS_URI
fast_dds   the XML profiles of Fast DDS
session    all settings of a session, as the chosen RMW would have them
"""
