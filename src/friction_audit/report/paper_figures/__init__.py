"""Courses of joints -> figures in the layout of the paper's."""
