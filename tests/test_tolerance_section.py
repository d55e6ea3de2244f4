"""The section on error against run time of a run that sweeps its tolerance."""

import numpy as np
import pytest

from clearsweep.report.sections.setup import PATH, differences

PEAK = "j_force_peak"


def test_each_case_is_compared_with_the_finest_of_the_same_values():
    cases = {
        PATH: np.array([1e-4, 1e-6, 1e-8] * 2),
        "drive.speed": np.array([1.0] * 3 + [2.0] * 3),
        "run_time": np.array([1.0, 2.0, 4.0, 3.0, 6.0, 12.0]),
        PEAK: np.array([110.0, 101.0, 100.0, 8.0, 9.8, 10.0]),
    }
    tolerances, run_times, changes = differences(cases, ["drive.speed"], [PEAK]).T
    assert tolerances.tolist() == [1e-4, 1e-6]
    assert run_times.tolist() == [2.0, 4.0]
    assert changes.tolist() == pytest.approx([0.15, 0.015])


def test_a_case_without_a_finer_one_is_compared_with_itself_only():
    cases = {PATH: np.array([1e-4, 1e-8]), "law": np.array(["a", "b"]), "run_time": np.ones(2)}
    assert not len(differences(cases | {PEAK: np.array([1.0, np.nan])}, ["law"], [PEAK]))
