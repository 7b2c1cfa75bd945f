"""Mixed duty with noise: which alpha_hat survives it."""

import numpy as np
import pytest
from synthetic import MACHINE

from imo_analysis.errors import InputError
from imo_analysis.excitation.duty import KINDS, mixed_duty
from imo_analysis.excitation.figures import plot_duty
from imo_analysis.study import Study


@pytest.mark.slow
def test_across_with_a_small_modulation_keeps_alpha_and_the_papers_law_does_not():
    from imo_analysis.simulation.run import simulate

    study = mixed_duty(Study.paper(), 60.0, depth=0.0158, frequency=136.3)
    run = simulate(study)
    late = run.sel(time=slice(20.0, None)).alpha_hat - MACHINE.alpha
    rms = {name: float(np.sqrt((late.sel(observer=name) ** 2).mean())) for name in KINDS}
    assert rms["across"] < 0.05 < rms["repaired"] < rms["consistent_12"]
    assert rms["consistent_12"] > 1.0
    assert len(plot_duty(run, MACHINE.alpha).axes) == 2


@pytest.mark.slow
def test_speed_steps_do_not_move_the_alpha_of_across():
    """Without noise, at constant flux: the drift of the other laws is gone (claim noise.across, resting.drift)."""
    from imo_analysis.simulation.run import simulate

    base = mixed_duty(Study.paper(), 10.0, noise=0.0).only(["repaired", "across"])
    study = base.changed({"reference.time": [0.0, 3.0, 6.0], "reference.omega": [40.0, 100.0, 40.0],
                          "load.time": [0.0], "load.T_l": [3.0]})
    run = simulate(study).sel(time=slice(2.9, None))
    ends = run.alpha_hat.isel(time=[0, -1])
    moved = {name: float(abs(ends.sel(observer=name).diff("time")).max()) for name in ("repaired", "across")}
    assert moved["across"] < 0.01 * moved["repaired"] and moved["repaired"] > 0.3


def test_duty_is_reproducible_and_needs_its_observers():
    one, two = (mixed_duty(Study.paper(), 100.0, seed=7) for _ in range(2))
    assert one.sha256 == two.sha256 != mixed_duty(Study.paper(), 100.0, seed=8).sha256
    with pytest.raises(InputError, match="needs an observer of kind repaired"):
        mixed_duty(Study.paper().only(["baseline"]), 100.0)
