"""Any result -> one self-contained HTML page: parts, the page that holds them, and a module per kind of result."""
