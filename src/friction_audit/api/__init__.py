"""The names at the top of the package, behind which everything else may move."""
