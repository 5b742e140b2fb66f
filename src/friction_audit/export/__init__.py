"""Joint models in the files of simulators and controllers."""
