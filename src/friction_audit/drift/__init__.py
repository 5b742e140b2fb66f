"""Session summaries -> ArmDrift: trends, change points, and how sure we are."""
