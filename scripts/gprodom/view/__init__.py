"""A drive on one screen, drawn by Rerun."""
