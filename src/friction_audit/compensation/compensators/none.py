"""No compensator: what everything else is measured against."""

from types import NoneType

from friction_audit.compensation.compensators.law import NONE, CompensatorKind

COMPENSATOR = CompensatorKind(name="none", summary="no compensation", settings=NoneType, code=NONE)
