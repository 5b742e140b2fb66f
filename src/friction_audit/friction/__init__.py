"""EnergyCycles -> FrictionHistory: the estimators of the paper and the better ones."""
