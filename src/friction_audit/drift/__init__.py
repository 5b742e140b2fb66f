"""Session summaries -> DriftReport: trends, change points, and how sure we are."""
