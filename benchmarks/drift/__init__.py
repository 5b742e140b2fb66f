"""What drift between sessions can be separated from, on simulated recordings and on summaries that scatter alike."""
