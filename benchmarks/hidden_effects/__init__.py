"""How often `diagnose` is right on logs in which an effect is hidden."""
