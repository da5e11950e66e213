"""Trajectories against truth: association, alignment, figures, tables and pictures."""
