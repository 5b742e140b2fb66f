"""Joint models in the files of simulators and controllers: one module per format, and their registry."""
