"""Many logs -> the sessions of a ledger: found, told apart, worked through side by side, each exactly once."""
