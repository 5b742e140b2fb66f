"""Cycles of short logs cut into parts, by hand."""

import numpy as np
import pytest

from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.omnibus import FEW_TO_TEST, LEAST_CLUSTERS, cut_cycles, even_weights


def test_many_cycles_stay_whole() -> None:
    cycle = np.repeat(np.arange(FEW_TO_TEST), 20)
    assert np.array_equal(cut_cycles(cycle, 1.0), cycle)


def test_few_cycles_are_cut_evenly_in_the_order_of_time() -> None:
    part = cut_cycles(np.repeat([3, 5, 9], 100), 2.0)
    parts, length = np.unique(part, return_counts=True)
    assert len(parts) == FEW_TO_TEST
    assert set(length.tolist()) == {10}
    assert np.all(np.diff(part) >= 0)
    assert len(np.unique(part[:100])) == FEW_TO_TEST // 3


def test_parts_outlast_the_memory_down_to_twelve() -> None:
    cycle = np.repeat(np.arange(4), 100)
    assert len(np.unique(cut_cycles(cycle, 12.0))) == 4 * 5
    assert len(np.unique(cut_cycles(cycle, 1000.0))) == LEAST_CLUSTERS


def test_clusters_of_a_short_log_weigh_by_the_root_of_their_size() -> None:
    residual, cluster = np.array([1.0, -1.0, 4.0, -4.0]), np.array([0, 0, 1, 1])
    assert even_weights(residual, cluster, 5) == pytest.approx([1.0, 1.0, 0.5, 0.5])
    assert even_weights(residual, cluster, FEW_TO_TEST) == pytest.approx(np.ones(4))
    assert np.all(np.isfinite(even_weights(0.0 * residual, cluster, 5)))


def test_a_group_without_what_is_zero_or_too_wide() -> None:
    wide, thin = np.ones((5, 3)), np.zeros((5, 3))
    thin[:, 1] = 2.0
    narrow = Group(name="toy", shapes=(wide, thin)).narrow(2)
    assert narrow is not None
    assert [shape.shape for shape in narrow.shapes] == [(5, 1)]
    assert Group(name="toy", shapes=(wide,)).narrow(2) is None
