"""Joint effects: formula, names, units, bounds and words of each in one module; joint models made of them."""
