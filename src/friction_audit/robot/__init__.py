"""The rigid-body model of the arm: gravity, inverse dynamics, hand velocity; payload. Pinocchio does the dynamics."""
