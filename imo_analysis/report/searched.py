"""The search of ``imo tune`` for the dossier: an adaptive observer and the baseline, made beside the simulations.

`compute` runs in the process of `imo_analysis.report.checks` and gives plain data; `drawn` reads them and draws.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imo_analysis.errors import InputError
from imo_analysis.report.scenarios import Drawn, keep
from imo_analysis.study import Study

if TYPE_CHECKING:
    from imo_analysis.tuning.tune import Tuned

# Kinds that are searched for: the first that the study has of either row.
ROWS = (("repaired", "quiet", "across", "supervised", "consistent_12"), ("baseline", "baseline_scheduled"))


@dataclass(frozen=True)
class Searched:
    """Results with their figure; ``refused`` says what could not be searched for."""

    results: list[Tuned]
    figure: Drawn | None
    refused: list[str]


def compute(study: Study) -> dict[str, Any]:
    """Search: ``results`` as plain data, ``refused`` with the reasons."""
    from imo_analysis.tuning.tune import tune

    results, refused = [], []
    for kinds in ROWS:
        name = next((name for kind in kinds for name, one in study.observers.items() if one.kind == kind), None)
        if name is None:
            continue
        try:
            results.append(asdict(tune(study, name)))
        except InputError as error:
            if str(error) not in refused:
                refused.append(str(error))
    return {"results": results, "refused": refused}


def drawn(study: Study, data: dict[str, Any], folder: Path) -> Searched:
    """What `compute` gave, as it was, with the figure."""
    from imo_analysis.tuning.data import front_data
    from imo_analysis.tuning.figures import tuning_figure
    from imo_analysis.tuning.tune import over_speed

    results = [_tuned(one) for one in data["results"]]
    if not results:
        return Searched([], None, data["refused"])
    figure = tuning_figure(front_data(study, results), over_speed(study, results))
    return Searched(results, keep(
        folder, "searched", figure, "What the search finds. Above: the least noise for wished times, with the gains of the "
        "study, the rule's, and the chosen ones. Below: settling time and noise over the speed, the study's thin and pale."),
        data["refused"])


def _tuned(data: dict[str, Any]) -> Tuned:
    from imo_analysis.tuning.schedule import Alone
    from imo_analysis.tuning.search import Found
    from imo_analysis.tuning.tune import Tuned
    from imo_analysis.tuning.verify import Verified

    single = {key: Found(**data[key]) for key in ("before", "rule", "chosen")}
    checked = {key: Verified(**data[key]) for key in ("verified_before", "verified_rule", "verified")}
    front = [Found(**one) for one in data["front"]]
    schedule = [Alone(**one) for one in data["schedule"]]
    return Tuned(**{**data, "signs": tuple(data["signs"]), "front": front, "schedule": schedule, **single, **checked})
