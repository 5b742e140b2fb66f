"""The next recording: the motion that decides between effects, and what `diagnose` would then answer."""
