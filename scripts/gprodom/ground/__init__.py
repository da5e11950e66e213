"""Ground by full-wave simulation: scenes, their FDTD with gprMax, and survey lines of it."""
