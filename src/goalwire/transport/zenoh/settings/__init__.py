"""The configuration of a session, read from environment variables and files.

    values             a configuration as JSON values, and access to a setting by its path
    built_in           rmw_zenoh's settings, and the few that goalwire changes
    environment        the variables that say how sessions are opened
    json5              JSON5, read with the line of each setting
    schema             the known settings, and the values that each takes
    reader             files and overrides, read and checked
    plan               a session to open, and a rendezvous to offer beside it
    native             the settings of goalwire's own session, or the reason why eclipse-zenoh is needed
    fleet              the settings of a fleet's routers
    secured_rmw_zenoh  whole configurations for rmw_zenoh's router and sessions, with the rules of a policy

Only `reader` opens files, and it checks everything that it returns against the schema.
"""
