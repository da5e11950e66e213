"""``gprodom commission``: the configuration of a new robot, from one recording."""
