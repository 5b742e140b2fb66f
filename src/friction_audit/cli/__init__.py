"""The command line: read, one library call, write."""
