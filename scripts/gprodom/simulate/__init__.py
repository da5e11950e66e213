"""Drives, sensors and ground made up from a seed."""
