"""Any result -> table, JSON, figures."""
