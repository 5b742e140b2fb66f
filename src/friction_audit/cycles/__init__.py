"""Interaction -> EnergyCycles: segmentation and energy sums."""
