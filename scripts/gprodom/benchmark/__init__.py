"""Methods on sequences: trajectories, results.csv, results.json, report.html."""
