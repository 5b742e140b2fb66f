"""JointLog -> file; tables of results -> files."""
