"""From energy cycles to friction coefficients: the estimators of the paper and the better ones."""
