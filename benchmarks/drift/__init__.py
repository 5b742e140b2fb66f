"""What drift between sessions can be told from, on simulated recordings and on summaries that scatter as those do."""
