"""Comparison of the compensation methods with the same operator, arm, noise and seeds."""
