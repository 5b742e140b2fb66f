"""JointLog -> Interaction: the torque at the friction port, its sign and its provenance."""
