"""Settings and a seed -> JointLog with known truth."""
