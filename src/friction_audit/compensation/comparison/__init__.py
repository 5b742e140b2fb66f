"""The compensation methods side by side: same operator, same arm, same noise, same seeds."""
