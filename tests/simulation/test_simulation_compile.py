"""The code that runs is the code that is proved, and the cache never runs anything else."""

import os
import subprocess
import sys
import warnings

import numpy as np
import pytest

from imo_analysis import compile as compiler
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.equations.plant import plant
from imo_analysis.simulation import drive, kernel, loaded_machine

DEFINITIONS = [
    *(observer.rates for observer in OBSERVERS.values()), *dict.fromkeys(observer.flux for observer in OBSERVERS.values()),
    plant, drive.control, drive.flux_model, loaded_machine.machine_rates,
]


@pytest.mark.parametrize("definition", DEFINITIONS, ids=lambda f: f.__qualname__)
def test_compiled_code_is_the_same_object(definition):
    seen, waiting = set(), [definition]
    while waiting:
        function = waiting.pop()
        if function in seen:
            continue
        seen.add(function)
        compiled = compiler.compiled(function)
        assert compiled.py_func.__code__ is function.__code__
        for name, called in compiler._callees(function):
            assert compiled.py_func.__globals__[name] is compiler.compiled(called)
            waiting.append(called)


@pytest.mark.parametrize("name", OBSERVERS)
def test_compiled_values_are_the_plain_ones(name):
    """To a unit in the last place: both do the same operations in the same order."""
    observer, rng = OBSERVERS[name], np.random.default_rng(3)
    x, i, u = (tuple(rng.normal(size=n) * 50) for n in (len(observer.states), 2, 2))
    p, gains = tuple(rng.uniform(0.1, 5, 5)), tuple(rng.uniform(0.1, 50, len(observer.gains)))
    plain, fast = observer.rates(x, i, u, -1.0, p, gains), compiler.compiled(observer.rates)(x, i, u, -1.0, p, gains)
    np.testing.assert_allclose(fast, plain, rtol=1e-15, atol=0)


def weighted(x, y, z):
    return x * y + z


def test_fused_products_stay_where_they_are_wanted():
    """A caller with fused products compiles the definition first; for all others it stays the definition to the bit."""
    import numba

    plain = compiler.compiled(weighted)

    @numba.njit(fastmath={"contract"})
    def caller(x, y, z):
        return plain(x, y, z)

    numbers = np.random.default_rng(5).normal(size=(500, 3)).tolist()
    caller(1.0, 2.0, 3.0)
    assert [plain(*each) for each in numbers] == [weighted(*each) for each in numbers]
    assert compiler.compiled(weighted, fused=True) is not plain


def outer(x):
    return inner(x) + 1.0


def inner(x):
    return 2.0 * x


def test_a_changed_equation_is_another_kernel(monkeypatch):
    """The change is in a function that the entry reaches through another, where numba's own cache does not look."""
    before = compiler.fingerprint("text", [outer])
    assert compiler.fingerprint("text", [outer]) == before
    assert compiler.fingerprint("text ", [outer]) != before

    def changed(x):
        return 3.0 * x

    monkeypatch.setitem(globals(), "inner", changed)
    assert compiler.fingerprint("text", [outer]) != before


@pytest.mark.slow
def test_a_changed_equation_runs_and_an_old_one_is_not_compiled_again(tmp_path):
    """Three processes on one cache: as it is, with an edited equation, as it is."""
    program = (
        "import inspect\nimport imo_analysis.equations.plant as e\n"
        "text = inspect.getsource(e.plant)\nedited = text.replace({old!r}, {new!r})\n"
        "if edited != text:\n    exec(edited, e.__dict__)\n"
        "from imo_analysis.simulation.kernel import kernel, Loop\n"
        "from imo_analysis.simulation.run import simulate\nfrom imo_analysis.study import Study\n"
        "run = simulate(Study.paper().only([]).changed({{'simulation.duration': 0.02}}))\n"
        "print(float(run.omega[-1]), len(kernel(Loop()).stats.cache_hits))\n"
    )
    environment = {**os.environ, "IMO_CACHE_DIR": str(tmp_path)}
    answers = []
    for new in ("n_p * T_l / J", "n_p * (T_l + 1.0) / J", "n_p * T_l / J"):
        text = program.format(old="n_p * T_l / J", new=new)
        done = subprocess.run([sys.executable, "-c", text], env=environment, capture_output=True, text=True, check=True)
        answers.append(done.stdout.split())
    values, hits = zip(*answers, strict=True)
    assert values[0] == values[2] != values[1]
    assert hits == ("0", "0", "1")
    assert not [path for path in tmp_path.rglob("*") if path.name.startswith(".imo_kernel")]


def test_without_a_place_for_the_cache_it_works_with_a_warning(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("IMO_CACHE_DIR", str(tmp_path / "file"))
    text = kernel.source(kernel.Loop()) + "\n# another text, so that it is not in memory\n"
    functions = {"machine_rates": loaded_machine.machine_rates, "direction_of": loaded_machine.direction_of,
                 "control": drive.control, "flux_model": drive.flux_model}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = compiler.entry(text, functions)
    assert any("IMO_CACHE_DIR" in str(warning.message) for warning in caught)
    x, c, lost = np.zeros(5), np.zeros(7), np.full(1, -1)
    parameters = (0.4, 0.06, 0.003, 308.0, 9.9, 357.0, 2.0, 0.016)
    done = run(0, 10, 1, 1e-4, 1, 1e6, x, c, np.zeros((5, 10)), (1.0, 1.0, 0.0, 0.0, 0.0), parameters, 0.0,
               (1e-4, 1500.0, 30.0, 45.0, 400.0, 60.0, 0.03), np.empty((10, 9)), lost)
    assert done == 10
