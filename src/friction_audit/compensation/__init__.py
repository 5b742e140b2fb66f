"""Friction compensators with a passivity controller: their laws, their replay on a log, and their comparison."""

FEEDBACK = ("disturbance_observer", "torque_regulation")  # compensators that need a closed-loop simulation
MODEL = "model"  # feedforward of the friction of a model file
COMPETITORS = ("fixed", "sigmoid", "lugre", *FEEDBACK, MODEL)  # compensators other than ``energy``
SAME_MOTION, SAME_TORQUE, SAME_OPERATOR = "same-motion", "same-torque", "same-operator"
# Assumption of a replay: what stays as recorded although the compensator changes the joint.
ASSUMES = (SAME_MOTION, SAME_TORQUE, SAME_OPERATOR)
