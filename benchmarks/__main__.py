"""``python -m benchmarks``: the table of ratios, everything measured side by side in this run.

Contenders take turns in many short stretches; a figure is the median of the ratios of neighbouring stretches, in CPU time of
this process (wall time for threads). Other work on the machine then disturbs both sides alike. Absolute times are given beside
the ratios for orientation only.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import c_code, contenders, motulator_way, poles
from imo_analysis.simulation.run import simulate_labelled
from imo_analysis.simulation.runge_kutta import METHODS
from imo_analysis.sweeps.batch import processors
from imo_analysis.sweeps.sweep import sweep


def ratio(
    one: Callable[[], Any], other: Callable[[], Any], repeats: int, clock: Callable[[], float] = time.process_time
) -> tuple[float, float, float]:
    """Median of time(one) / time(other) over neighbouring stretches, and the median times in s; one call of each before."""
    one()
    other()
    times = []
    gc.disable()
    for n in range(repeats):
        pair = []
        for function in (one, other) if n % 2 else (other, one):
            start = clock()
            function()
            pair.append(clock() - start)
        times.append(pair if n % 2 else pair[::-1])
    gc.enable()
    values = np.array(times)
    return float(np.median(values[:, 0] / values[:, 1])), *(float(value) for value in np.median(values, axis=0))


def even(what: str, value: float, detail: str) -> dict[str, Any]:
    """A line whose ratio must be 1 within 10 %, either way."""
    return {**row(what, value, 1.10, False, detail), "reached": bool(1 / 1.10 <= value <= 1.10)}


def row(what: str, value: float, bound: float, least: bool, detail: str) -> dict[str, Any]:
    """A line of the table; ``least`` where the bound is a lower one."""
    return {"figure": what, "value": float(value), "bound": bound, "at_least": least,
            "reached": bool(value >= bound if least else value <= bound), "detail": detail}


def one_loop(quick: bool) -> list[dict[str, Any]]:
    """One closed loop against C, and against Python's ways."""
    rows = []
    long = contenders.task(2000)
    per_second = 1e3 / long.seconds
    repeats = 40 if quick else 200
    if c_code.compiler():
        value, mine, theirs = ratio(lambda: contenders.ours(long), lambda: contenders.c_single(long), repeats)
        rows.append(row("one closed loop / hand-written C", value, 1.10, False,
                        f"{mine * per_second:.3g} and {theirs * per_second:.3g} ms per second of motor time"))
    else:
        print("no C compiler found (CC, cc, gcc, clang): the comparisons with C are left out", file=sys.stderr)
    short = contenders.task(100, settled=0.5)
    exact = contenders.exact(short)

    def error(states: np.ndarray) -> float:
        return float(np.max(np.abs(states - exact)) / np.max(np.abs(exact)))

    ways: list[tuple[str, Callable[[], Any], float]] = [
        ("scipy solve_ivp per sample", lambda: contenders.scipy_per_sample(short, 1e-3), 1),
        ("python-control, input_output_response per sample", lambda: contenders.control_per_sample(short, 1e-3), 500),
        # at 1e-3 it is six times cheaper and steps over the voltage's edges: an error of 2e-3
        ("python-control, one call, rtol 1e-5", contenders.control_in_one(short, 1e-5), 500),
        ("python-control, one call, rtol 1e-3 (coarse)", contenders.control_in_one(short, 1e-3), 1),
        ("the same definitions, not compiled", lambda: contenders.plain_python(short), 1),
    ]
    try:
        import motulator  # noqa: F401
        ways.append(("motulator, with this drive and observer in it", lambda: motulator_way.same_task(short), 1000))
    except ImportError:
        print("motulator is not installed (extra bench): left out", file=sys.stderr)
    for name, way, bound in ways:
        wrong = error(way())
        work, task = as_accurate(short, wrong, error)
        value, theirs, mine = against(way, task, quick)
        rows.append(row(f"{name} / ours", value, bound, True,
                        f"{theirs:.4g} and {mine:.3g} ms per second; largest scaled error {wrong:.0e}, ours "
                        f"{error(contenders.ours(task)):.0e} in {work}"))
    if "motulator" in sys.modules:
        value, theirs, mine = against(lambda: motulator_way.own_drive(short.seconds), short, quick)
        rows.append(row("motulator at 10 kHz with its own sensorless drive / ours", value, 1000, True,
                        f"{theirs:.4g} and {mine:.3g} ms per second; another drive: no accuracy to compare"))
    return rows


def as_accurate(short: contenders.Task, wrong: float, error: Callable[[np.ndarray], float]) -> tuple[str, contenders.Task]:
    """The cheapest order and steps a sample whose error is no more than a tenth above ``wrong``: in words, and the task."""
    cheapest = sorted((steps * method.evaluations, order, steps) for order, method in METHODS.items() for steps in range(1, 20))
    for _, order, steps in cheapest:
        task = replace(short, study=short.study.changed({"simulation.substeps": steps, "simulation.order": order}))
        if error(contenders.ours(task)) <= 1.1 * wrong:
            return f"{steps} step{'s' * (steps > 1)} of order {order} a sample", task
    raise ValueError(f"no number of steps below 20 reaches an error of {wrong:.1e}")


def against(way: Callable[[], Any], task: contenders.Task, quick: bool) -> tuple[float, float, float]:
    """A contender's time over ours for the task, and both in ms per second of motor time."""
    many, scale = 100, 1e3 / task.seconds
    ours = contenders.prepared(task)

    def repeated() -> None:
        for _ in range(many):
            ours()

    value, theirs, mine = ratio(way, repeated, 3 if quick else 7)
    return value * many, theirs * scale, mine / many * scale


def batches(quick: bool) -> list[dict[str, Any]]:
    """1,024 different machines and gains against C over lanes, and two threads against one."""
    rows = []
    machines = 1024
    samples = 2000 if quick else 5000
    task = contenders.task(samples)
    values = contenders.different(task.study, machines)
    per = 1e3 / machines / task.seconds
    if c_code.compiler():
        widths = {width: contenders.CLanes(task, values, width) for width in (8, 16, 32, 64, 128)}
        best = min(widths, key=lambda width: min(_timed(widths[width]) for _ in range(5)))
        other = widths[best]
        value, mine, theirs = ratio(lambda: contenders.batch(task, values), other, 9 if quick else 25)
        rows.append(row("1,024 different machines, one thread / C over lanes", value, 1.20, False,
                        f"{mine * per:.3g} and {theirs * per:.3g} ms per machine and second; best of five block "
                        f"widths of that C: {best}"))
    threads = min(2, processors())
    value, one, two = ratio(lambda: contenders.batch(task, values), lambda: contenders.batch(task, values, threads),
                            7 if quick else 25, time.perf_counter)
    work, _, _ = ratio(lambda: contenders.batch(task, values, threads), lambda: contenders.batch(task, values),
                       7 if quick else 15)
    rows.append(row("two threads against one, wall time (needs two idle cores)", value, 1.8, True,
                    f"{one * per:.3g} and {two * per:.3g} ms per machine and second; CPU time of two threads / of one "
                    f"{work:.3g}; load of the machine {os.getloadavg()[0]:.1f}"))
    return rows


def growth(quick: bool) -> list[dict[str, Any]]:
    """Cost and memory against length and number."""
    rows = []
    study = contenders.task(100).study
    longest = 100 if quick else 1000

    def single(seconds: float) -> Callable[[], Any]:
        lengthened = study.changed({"simulation.duration": seconds, "simulation.record_every": 1000})
        return lambda: simulate_labelled(lengthened)

    # runs and sweeps have a set-up, so what must stay constant is the cost of one more second, and of one more machine
    early, late, first = _marginal([(seconds, single(seconds)) for seconds in (1, 11, longest + 1)], 5 if quick else 9)
    rows.append(even(f"one more second of motor time, up to {longest} s / up to 11 s", late / early,
                     f"{late * 1e3:.3g} and {early * 1e3:.3g} ms; set-up of a run {first * 1e3:.2g} ms"))
    few, more, most = 1_000, 6_000 if quick else 11_000, 20_000 if quick else 100_000
    early, late, first = _marginal([(number, small_sweep(number)) for number in (few, more, most)], 3 if quick else 5)
    rows.append(even(f"one more machine in a sweep, from {few:,} on: up to {most:,} / up to {more:,}", late / early,
                     f"{late * 1e6:.3g} and {early * 1e6:.3g} us; set-up of a sweep {first * 1e3:.2g} ms, as much as "
                     f"{first / early:.0f} machines"))
    large, small = _peak_of(most), _peak_of(few)
    rows.append(row(f"peak memory of a sweep of {most:,} machines / of {few:,}", large / small, 1.10, False,
                    f"{large / 1e6:.0f} and {small / 1e6:.0f} MB"))
    return rows


def small_sweep(machines: int) -> Callable[[], Any]:
    """A sweep over so many machines, all of them different, of 20 ms each."""
    study = contenders.task(100).study
    plain = type(study).from_data({key: value for key, value in study.data.items() if key not in ("sweep", "scenarios")})
    study = plain.changed({
        "simulation.duration": 0.02, "reference": {"time": [0.0], "omega": [20.0]},
        "sweep": {"runs": machines, "hold": 0.005,
                  "fields": {"machine.R_r": {"relative": 0.5}, "machine.R_s": {"relative": 0.5}}},
    })
    return lambda: sweep(study, jobs=1)


def _peak_of(machines: int) -> float:
    """Peak memory in bytes of a process that makes `small_sweep` and nothing else."""
    text = f"from benchmarks import __main__ as table; table.small_sweep({machines})(); print(table._memory())"
    done = subprocess.run([sys.executable, "-c", text], check=True, capture_output=True, text=True,
                          cwd=Path(__file__).resolve().parents[1])
    return float(done.stdout)


def _marginal(tasks: list[tuple[int, Callable[[], Any]]], repeats: int) -> tuple[float, float, float]:
    """CPU seconds of one more unit between the first two of three sizes and between the last two, and of none at all."""
    tasks[0][1]()
    start, middle, end = np.median([[_timed(task) for _, task in tasks] for _ in range(repeats)], axis=0)
    (few, _), (more, _), (most, _) = tasks
    early = (middle - start) / (more - few)
    return early, (end - middle) / (most - more), start - few * early


def _timed(function: Callable[[], Any]) -> float:
    start = time.process_time()
    function()
    return time.process_time() - start


def _memory() -> float:
    """Peak memory of this process in bytes. Linux's ru_maxrss begins at the parent's: it would hide what a child needs."""
    status = Path("/proc/self/status")
    if status.is_file():
        return 1024.0 * next(float(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1.0 if sys.platform == "darwin" else 1024.0)


def atlas(quick: bool) -> list[dict[str, Any]]:
    """Poles: the closed form against C, batches against a loop over python-control."""
    return poles.lines(quick, ratio, row)


def command(quick: bool) -> list[dict[str, Any]]:
    """The whole command ``imo simulate`` on the paper's study of 60 s, in a fresh process with a warm cache."""
    import resource

    with tempfile.TemporaryDirectory() as folder:
        arguments = [sys.executable, "-m", "imo_analysis.cli", "simulate", "--out", str(Path(folder) / "run.nc")]
        walls, cpus = [], []
        for n in range(4 if quick else 8):
            usage = resource.getrusage(resource.RUSAGE_CHILDREN)
            start = time.perf_counter()
            subprocess.run(arguments, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            wall = time.perf_counter() - start
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            if n:  # the first fills the cache
                walls.append(wall)
                cpus.append(after.ru_utime + after.ru_stime - usage.ru_utime - usage.ru_stime)
    return [row("imo simulate, 60 s, whole command, seconds", float(np.median(walls)), 2.5, False,
                f"{np.median(cpus):.2f} s of CPU; load of the machine {os.getloadavg()[0]:.1f}")]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__.splitlines()[0].split(": ")[1])
    parser.add_argument("--quick", action="store_true", help="fewer repeats and shorter runs: a minute instead of several")
    parser.add_argument("--json", metavar="FILE", help="write the rows as JSON")
    arguments = parser.parse_args()
    rows = []
    print(f"| {'figure':<62} | {'measured':>9} | {'to reach':>9} |    | beside it |")
    print(f"|{'-' * 64}|{'-' * 11}|{'-' * 11}|----|---|")
    for part in (one_loop, batches, growth, atlas, command):
        for line in part(arguments.quick):
            rows.append(line)
            sign = ">=" if line["at_least"] else "<="
            value = f"{line['value']:.3g}" if line["value"] < 1000 else f"{line['value']:,.0f}"
            reached = "ok" if line["reached"] else "no"
            print(f"| {line['figure']:<62} | {value:>9} | {sign} {line['bound']:>6,g} | {reached} | {line['detail']} |",
                  flush=True)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
