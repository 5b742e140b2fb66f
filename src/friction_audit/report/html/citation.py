"""How to cite the method and the program, the same on every page."""

from friction_audit import __version__
from friction_audit.report.html.parts import Section, Text

METHOD = (
    "H. T. Dinc, J.-K. Lee, J.-H. Ryu, Model-Free Energy-Based Friction Compensation for Industrial Collaborative "
    "Robots as Haptic Displays, IEEE/ASME Transactions on Mechatronics, 2024, doi 10.1109/TMECH.2024.3410330."
)
PROGRAM = f"friction-audit {__version__}. The program is not by the authors of the method."


def citation_section() -> Section:
    """Return how to cite."""
    lead = "Friction is estimated from the energy balance between two moments of rest. When you publish, cite"
    parts = (Text(lines=(lead,)), Text(lines=(METHOD, PROGRAM), listed=True))
    return Section(anchor="cite", title="How to cite", parts=parts)
