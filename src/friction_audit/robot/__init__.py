"""The rigid-body model of the arm: gravity, inverse dynamics, hand velocity; payload. MuJoCo does the dynamics."""
