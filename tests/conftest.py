"""The studies that several tests share."""


import pytest

from imo_analysis.study import Study


@pytest.fixture(scope="session")
def paper():
    return Study.paper()


@pytest.fixture(scope="session")
def turning(paper):
    """A short run that starts magnetised and turning, with all three observers off their marks."""
    off = {"alpha_hat": 8.0, "omega_hat": 55.0, "i_ds_hat": 7.0, "z_1_hat": 150.0, "xi_1_hat": 155.0}
    return paper.changed({
        "simulation.duration": 0.05, "simulation.record_every": 1,
        "initial": {"phi_dr": 0.5, "omega": 60.0, "i_ds": 8.0},
        "reference.time": [0.0, 0.02], "reference.omega": [60.0, 80.0],
        "load": {"time": [0.0, 0.03], "T_l": [0.0, 5.0]}, "machine.B": 0.002,
        "observers.baseline.initial": {"phi_dr_hat": 0.45, "omega_hat": 55.0, "i_ds_hat": 7.0},
        "observers.consistent_12.initial": off,
        "observers.repaired.initial": off,
    })
