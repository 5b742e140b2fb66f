"""What a simulated log does not say -> JSON document ``friction-audit/truth/1``."""

from friction_audit.report.document import Document, new_document, to_json
from friction_audit.report.simulate_document import SimulatedLog, effects_document


def truth_document(simulated: SimulatedLog) -> Document:
    """Return the truth of a log: everything that was simulated, and the hash that tells which log it is."""
    return {
        **new_document("truth"),
        "scenario": simulated.scenario,
        "seed": simulated.seed,
        "log_sha256": simulated.sha256,
        "settings": to_json(simulated.settings),
        "effects": effects_document(simulated.effects),
    }
