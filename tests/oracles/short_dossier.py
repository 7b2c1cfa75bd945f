"""A short study for tests of the dossier."""

from imo_analysis.study import Study


def short_dossier_study() -> Study:
    """The paper's study with three of its scenarios, seconds long."""
    data = dict(Study.paper().data)
    data["simulation"] = {**data["simulation"], "duration": 5.0}  # the mixed duty goes on as many times longer
    names = ("fig1", "fig4", "divergence")
    data["scenarios"] = {name: dict(data["scenarios"][name]) for name in (*names, "lyapunov")}
    for name in names:
        data["scenarios"][name]["simulation"] = {"duration": 1.5, "record_every": 1}
    for name in ("fig1", "fig4"):
        data["scenarios"][name]["reference"] = {"time": [0.0, 1.0], "omega": [50.0, 100.0]}
        data["scenarios"][name]["windows"] = [{"title": "the step", "start": 1.0, "stop": 1.2, "caption": "50 to 100 rad/s"}]
    return Study.from_data(data)
