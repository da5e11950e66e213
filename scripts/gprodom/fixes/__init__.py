"""Positions from outside (position_fix_t): from logs, bags and tables, from markers, from truth."""
