"""Results -> figures; ``registry`` names the kinds."""
