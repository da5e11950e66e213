"""Displacement by networks from radar traces: training on simulated ground, inference, and what the
estimator is told. PyTorch is needed to train (`training`), onnxruntime to infer (`model`). What
the package gets of it: `room`; why, and what came of it: README.md.
"""
