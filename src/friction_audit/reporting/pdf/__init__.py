"""Page -> PDF, for paper and for the file of an arm."""
