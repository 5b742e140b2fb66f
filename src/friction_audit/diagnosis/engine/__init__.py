"""The diagnosis by one likelihood: generalised least squares, group selection, held-out validation."""
