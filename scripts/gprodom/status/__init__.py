"""``gprodom status``: what a running gprodomd says about itself."""
