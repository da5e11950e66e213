"""The trajectory by each method: dead reckoning, radar displacements, the estimator."""
