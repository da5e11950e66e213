"""Where the robot was, by each method: dead reckoning, radar displacements, the estimator."""
