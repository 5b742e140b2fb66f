"""Many logs -> the sessions of a ledger: found, identified, worked through side by side, each exactly once."""
