"""The configuration of a session: from the environment and its files to what a session is opened with.

    values       a configuration as values, and where in it a setting is
    built_in     rmw_zenoh's settings, and the few that goalwire changes
    environment  the variables that say how sessions are opened
    json5        JSON5, read with the line of each setting
    schema       the settings there are, and what each takes
    reader       files and overrides, read and checked
    plan         a session to open, and a rendezvous to offer beside it
    native       the settings of a session of goalwire's own, or why eclipse-zenoh must open it
    secured      whole configurations for rmw_zenoh's router and sessions, with the rules of a policy

Files are opened in `reader` only, and what it returns has been held against the schema.
"""
