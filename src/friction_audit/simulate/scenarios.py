"""The scenarios that have a name."""
