"""Recordings of other makes, turned into LCM logs."""
