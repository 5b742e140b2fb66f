"""The online compensator of the paper, as a controller runs it: one tick at a time, with its passivity controller."""
