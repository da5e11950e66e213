"""The estimate in the formats of other programs."""
