"""friction-audit: how much friction is in the joints, is it changing, and what does the model miss?"""

__version__ = "0.1.0"
