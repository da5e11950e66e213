"""A page about a drive that nobody scored."""
