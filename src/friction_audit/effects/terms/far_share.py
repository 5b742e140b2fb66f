"""The part of a joint's inertia that a spring or a play drives; the rest moves with the measured side, as a rotor."""

from friction_audit.effects.term import Parameter

FAR_SHARE = Parameter(
    name="far_share",
    unit="1",
    meaning="part of the inertia behind it, the rest on the measured side",
    lower=0.0,
    upper=1.0,
    optional=True,
    default=1.0,
)
