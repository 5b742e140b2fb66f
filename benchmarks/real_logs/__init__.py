"""Diagnoses of measured logs: seeds, halves, and effects added to the measured torque."""
