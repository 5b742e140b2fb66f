"""Parameters, the hand and what is hidden -> the true motion of the joints, by one compiled integrator."""
