"""A drive as it is shown: what was published, what the sensors said, and what went wrong."""
