"""``gprodom doctor``: what is wrong with a recording, and what mends it."""
