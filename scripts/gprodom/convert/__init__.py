"""Converts other recordings (CMU-GPR, ROS bags, tables, survey files) to LCM logs."""
