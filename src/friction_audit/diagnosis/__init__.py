"""Measured against simulated: where they disagree, what is missing, by name, and the gap after adding it."""
