"""What speaks for an effect: how much less is left with it, less what its numbers cost.

References:
    E. I. George, D. P. Foster, Calibration and empirical Bayes variable selection, Biometrika 87 (2000) 731: what a
    number costs if its usual size is that which the data show.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from friction_audit.diagnosis.ranking import Ranking
from friction_audit.joint_log import Float


def evidence(ranking: Ranking, others: Sequence[int], *units: int) -> float:
    """What speaks for some units beside others: L - k ln(L / k), L = n_eff ln(RSS without / RSS with).

    Their k numbers are their factors and what their shapes leave free. A number costs the logarithm of prior over
    posterior variance. With the effect's own mean square as the prior (George and Foster 2000) that is ln(L / k), where
    the prior of BIC, as large as the noise, gives ln(n_eff): weak effects would lose to any with fewer numbers, unseen.
    """
    gain = ranking.n_eff * np.log(ranking.rss(others) / ranking.rss([*others, *units]))
    numbers = sum(ranking.width[u] + ranking.products.units[u].numbers for u in units)
    return float(evidence_of(gain, numbers))


def evidence_of(gain: ArrayLike, numbers: ArrayLike) -> Float:
    """Evidence from n_eff ln(RSS without / RSS with) and how many numbers it took; either may be of many units."""
    gain, numbers = np.asarray(gain, float), np.maximum(numbers, 1)
    return np.asarray(gain - numbers * np.log(np.maximum(gain / numbers, 1.0)))
