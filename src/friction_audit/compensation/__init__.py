"""The online compensator of the paper, as a controller runs it: one tick at a time, with its passivity controller."""

FEED_BACK = ("disturbance_observer", "torque_regulation")  # without a loop over the motion their result means nothing
MODEL = "model"  # applies the friction of a model file
COMPETITORS = ("fixed", "sigmoid", "lugre", *FEED_BACK, MODEL)  # compensators other than ``energy``
SAME_MOTION, SAME_TORQUE, SAME_OPERATOR = "same-motion", "same-torque", "same-operator"
# What is assumed of the person, or of the arm's drive, who would have met another joint than the recorded one.
ASSUMES = (SAME_MOTION, SAME_TORQUE, SAME_OPERATOR)
