"""Comparison of the engines of the diagnosis on the same joints."""
