"""``gprodom status``: the state of a running gprodomd."""
