"""From a log to energy cycles: torque at the friction port, velocity, segmentation, energies."""
