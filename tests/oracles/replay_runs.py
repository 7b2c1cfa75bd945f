"""Records run through observers, as the tests of replay do it."""



from imo_analysis.replay.check import level
from imo_analysis.replay.estimate import Treatment, collect, provenance, runners
from imo_analysis.replay.logs import Log
from imo_analysis.replay.survey import survey


def prepared(path, machine, names=("repaired",), treatment=None, bridge=False, **more):
    log = Log.open(path, machine.n_p, more.pop("columns", None), more.pop("units", None))
    found = survey(log, bridge)
    now = level(found.stretch.u_ds + 1j * found.stretch.u_qs, found.stretch.i_ds + 1j * found.stretch.i_qs,
                found.sample_time, machine)
    treatment = treatment or Treatment(direction="measured")
    return log, found, runners(list(names), machine, treatment, found, now, **more)


def replayed(path, machine, names=("repaired",), treatment=None, rows=65_536, **more):
    log, found, observers = prepared(path, machine, names, treatment, **more)
    return collect(log, observers, provenance(log, machine, observers, observers[0].treatment), rows=rows), found, observers


def error(data, name, after):
    kept = data.sel(observer=name).isel(time=(data.time.values - data.time.values[0]) > after)
    return (kept.omega_hat - kept.omega).values


def cut(rows, first):
    rows = rows[first:].copy()
    rows[:, 0] -= rows[0, 0]
    return rows
