"""An independent judge of ``diagnose``: logs from other physics than the simulator's.

Nothing here is shared with ``friction_audit.simulation`` or ``benchmarks.hidden_effects``: friction has states (LuGre,
Maxwell-slip), play is a dead zone between two inertias, sensors are read late, encoders count steps.
"""
