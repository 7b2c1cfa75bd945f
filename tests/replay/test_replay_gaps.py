"""Records with gaps: what the first pass finds, what the observers do over them, and the verdict on the stretches between."""

import json
import subprocess
import sys

import numpy as np
import pytest
from replay_records import HEADER, TABLE, start_up, steady, write
from replay_runs import error, prepared, replayed

from imo_analysis import cli
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.replay.estimate import estimate
from imo_analysis.replay.kernel import source
from imo_analysis.replay.logs import Log
from imo_analysis.replay.summary import Tally
from imo_analysis.replay.survey import survey

PARTS = ((0, 2000), (2003, 2040), (2060, 9000), (9001, 15000), (16200, 20000))


def broken(rows, parts=PARTS):
    return np.concatenate([rows[slice(*part)] for part in parts])


@pytest.fixture(scope="module")
def gapped(folder):
    """A start of two seconds, and the same without some samples."""
    rows = start_up(2.0)
    return write(folder / "whole.csv", rows), write(folder / "gapped.csv", broken(rows))


# The first pass ------------------------------------------------------------------------------------------------------
def test_the_first_pass_finds_the_stretches(gapped):
    found = survey(Log.open(gapped[1], 2), bridge=True)
    assert found.gaps == 4 and found.first.tolist() == [0, 2000, 2037, 8977, 14976]
    assert found.since == pytest.approx([0.0, 0.2003, 0.206, 0.9001, 1.62], abs=1e-12)
    assert found.steps == pytest.approx([4e-4, 21e-4, 2e-4, 0.1201], abs=1e-12)
    assert found.sample_time == pytest.approx(1e-4, rel=1e-12) and found.most == 6940
    rows = np.arange(found.rows)
    assert found.time_of(rows) == pytest.approx(broken(np.arange(20000)[:, None] * 1e-4)[:, 0], abs=1e-9)
    assert found.time_of(found.rows) == pytest.approx(2.0)
    for part, size in ((found.head, 2000), (found.stretch, 6940)):
        assert len(part) == size
        assert np.diff(part.time) == pytest.approx(1e-4, rel=1e-6), "gains and start are told from samples without a gap"


def test_gaps_at_the_borders_of_a_block_and_of_the_record(folder):
    """The first sample of the second block behind a gap, a stretch of one sample first and last."""
    rows = steady(7.0)
    parts = ((0, 1), (5, 65540), (65550, 69990), (69999, 70000))
    found = survey(Log.open(write(folder / "borders.csv", broken(rows, parts)), 2), bridge=True)
    assert found.first.tolist() == [0, 1, 65536, 69976] and found.steps == pytest.approx([5e-4, 11e-4, 10e-4], abs=1e-9)


def test_parts_too_short_alone_are_joined(folder):
    """A steady state in parts of 40 samples, gaps of all lengths: joined it is a record without gaps."""
    rows = steady(3.0)
    starts = np.cumsum(np.random.default_rng(3).integers(42, 900, 60))
    path = write(folder / "short.csv", broken(rows, [(start, start + 40) for start in starts]))
    found = survey(Log.open(path, 2), bridge=True)
    whole = survey(Log.open(write(folder / "even.csv", rows[starts[0] : starts[0] + len(found.head)]), 2))
    assert len(found.head) == 60 * 40 - 59
    for part in (found.head, found.stretch):
        for name in ("u_ds", "u_qs", "i_ds", "i_qs", "omega"):
            assert getattr(part, name) == pytest.approx(getattr(whole.head, name), abs=1e-6)
    _, _, (one,) = prepared(path, TABLE, bridge=True)
    assert one.begun.values["omega_hat"] == pytest.approx(200.0, abs=0.1)


def test_broken_rows_are_refused_and_without_them_there_is_a_gap(folder):
    rows = steady(1.0)
    rows[5000:5003, 1:] = np.nan
    path = write(folder / "nan.csv", rows)
    with pytest.raises(InputError, match=r"line 5002: u_alpha = .nan. is not a number; .* take out the lines without values"):
        survey(Log.open(path, 2), bridge=True)
    lines = [line for line in path.read_text().splitlines() if "nan" not in line]
    path.write_text("\n".join(lines) + "\n")
    assert survey(Log.open(path, 2), bridge=True).first.tolist() == [0, 5000]


# The observers over a gap --------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", sorted({"baseline", "repaired", "luenberger_consistent_12", "baseline_scheduled"}))
def test_over_a_long_gap_a_steady_state_goes_on(folder, name):
    """An estimate that has settled stays right behind a gap of 0.7 s, wherever in the turn that ends."""
    rows = steady(2.5)
    path = write(folder / "steady-gap.csv", broken(rows, ((0, 15000), (22003, 25000))))
    data, _, observers = replayed(path, TABLE, [name], bridge=True)
    assert observers[0].lost < 0
    before, behind = np.abs(error(data, name, 0.0)[14000:15000]).max(), np.abs(error(data, name, 0.0)[15000:]).max()
    assert behind <= 1.05 * before + 1e-3
    i = data["i_ds_meas"].values + 1j * data["i_qs_meas"].values
    phi = (data["phi_dr_hat"].values + 1j * data["phi_qr_hat"].values)[0]
    assert phi[15000] / i[15000] == pytest.approx(phi[14999] / i[14999], rel=1e-9)


def test_a_start_with_gaps_is_followed(gapped):
    """Where a line over a gap of 0.12 s, of 19 turns, would throw the repaired observer off for good."""
    data, found, observers = replayed(gapped[1], TABLE, ["repaired"], bridge=True)
    assert np.abs(error(data, "repaired", 0.0)[-3000:]).max() < 0.005 * found.peak_speed
    log, found, observers = prepared(gapped[1], TABLE, ["repaired"], bridge=True)
    observers[0].longest = np.inf
    off = [block.values["omega_hat"][0] - block.values["omega"] for block in estimate(log, observers)]
    assert not np.abs(np.concatenate(off)[-3000:]).max() < 0.1 * found.peak_speed


@pytest.mark.parametrize("name", OBSERVERS)
def test_every_vector_of_a_state_turns_and_nothing_else(name):
    """By the text of the kernel: each state but alpha_hat, omega_hat, R_s_shift and the supervisor's S is in one pair."""
    states = OBSERVERS[name].states
    line = next(one for one in source(name).splitlines() if one.strip().startswith("x = (") and "a * x[" in one)
    turned = line.split("x = (")[1][:-1].split(", ")
    a, b = np.cos(0.7), np.sin(0.7)
    x = np.arange(1.0, 1.0 + len(states))
    out = np.array([eval(text, {"x": x, "a": a, "b": b}) for text in turned])
    seen = set()
    for first, second in (("i_ds_hat", "i_qs_hat"), ("phi_dr_hat", "phi_qr_hat"), ("z_1_hat", "z_2_hat"),
                          ("xi_1_hat", "xi_2_hat"), ("m_1d", "m_1q"), ("m_2d", "m_2q")):
        if first in states:
            d, q = states.index(first), states.index(second)
            assert out[d] + 1j * out[q] == pytest.approx((x[d] + 1j * x[q]) * np.exp(0.7j))
            seen |= {d, q}
    rest = set(range(len(states))) - seen
    assert all(out[n] == x[n] for n in rest) and {states[n] for n in rest} <= {"alpha_hat", "omega_hat", "S", "R_s_shift"}


# What is told --------------------------------------------------------------------------------------------------------
def test_times_of_the_summary_are_those_of_the_record(gapped):
    log, found, observers = prepared(gapped[1], TABLE, ["repaired"], bridge=True)
    tally = Tally(found, observers)
    for block in estimate(log, observers):
        tally.add(block)
    one = tally.results(after=1.7)["repaired"]
    assert one["counted_from"] == pytest.approx(1.7, abs=0.002)
    observers[0].lost = 15000
    assert tally.results()["repaired"]["lost_at"] == pytest.approx(1.6224)


def machine_file(folder):
    (folder / "machine.toml").write_text('[machine]\npreset = "table-iii"\n')
    return str(folder / "machine.toml")


def verdict(folder, path, capsys, *words):
    words = ["replay", str(path), "--machine", machine_file(folder), "--gaps", "bridge", *words]
    assert cli.main([*words, "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)["excitation"]["repaired"]


def test_the_verdict_is_on_the_stretches(folder, gapped, capsys):
    one = verdict(folder, gapped[1], capsys)
    assert (one["stretches"], one["stretches_too_short"]) == (5, 1) and one["window"] == pytest.approx(0.1)
    assert one["time"] == pytest.approx(1.8776) and one["time_judged"] == pytest.approx(1.84)
    reduced = one["conditions"]["reduced"]
    assert 0 < reduced["holding"] < reduced["windows"] == sum(row["windows"] for row in reduced["stretches"])
    assert reduced["stretches"][0]["holding"] == reduced["stretches"][0]["windows"] > 0, "the speed rises, magnetising"
    assert "5 stretches between gaps" in one["verdict"] and "too short for one" in one["verdict"]


def test_the_verdict_of_one_sample_in_some(folder, gapped, capsys):
    """Stretches are those of what is written; of the second, of 37 samples, one is left at most."""
    full, few = (verdict(folder, gapped[1], capsys, "--every", every) for every in ("1", "40"))
    assert few["stretches"] == 5 and few["time_judged"] == pytest.approx(full["time_judged"], abs=0.1)


def test_stretches_that_are_all_too_short(folder, gapped, capsys):
    text = verdict(folder, gapped[1], capsys, "--window", "1.5")["verdict"]
    assert "no verdict: window = 1.5 s must be at most that of the longest of 5 stretches between gaps, 0.694 s" in text


def test_it_says_what_is_done_over_gaps(folder, gapped, capsys):
    assert cli.main(["replay", str(gapped[1]), "--machine", machine_file(folder), "--gaps", "bridge"]) == 0
    said = capsys.readouterr().out
    assert "0 s to 2 s" in said and "2 gap(s) of up to 0.0004 s bridged by straight lines; 2 gap(s) of up to 0.1201 s" in said
    assert "passed over" in said
    with pytest.raises(InputError, match=r"line 2002 \(t = 0.2003 s\): .*3 sample\(s\) missing.*--gaps bridge"):
        survey(Log.open(gapped[1], 2))


def test_it_says_who_stays_off_where_the_load_changes_in_a_gap(folder, gapped, capsys):
    """Two steady states with a gap between them: the baseline finds the second; one that adapts alpha does from there only."""
    first, second = steady(1.0, slip=0.5), steady(4.0, slip=15.0)[13000:]
    path, behind = write(folder / "loaded.csv", np.vstack([first, second])), write(folder / "behind.csv", second)
    names = ["baseline", "repaired"]
    over, alone = (replayed(one, TABLE, names, bridge=True)[0] for one in (path, behind))
    last = {name: [np.abs(error(data, name, 0.0)[-3000:]).max() for data in (over, alone)] for name in names}
    assert max(last["baseline"]) < 1.0 and last["repaired"][1] < 1.0 < 10.0 < last["repaired"][0], last
    for record, wanted, said in ((path, "baseline,repaired", True), (path, "baseline", False), (behind, "repaired", False)):
        words = ["replay", str(record), "--machine", machine_file(folder), "--gaps", "bridge", "--observer", wanted]
        assert cli.main(words) == 0
        assert (" passed over, repaired may stay off behind it" in capsys.readouterr().out) is said


def test_no_line_is_drawn_over_a_gap(gapped):
    """Over 0.12 s and over the two milliseconds, both of several samples; not over one missing sample."""
    from imo_analysis.report.replay_figure import broken, replay_figure

    data, _, _ = replayed(gapped[1], TABLE, ["baseline"], bridge=True)
    for axes in replay_figure(data).axes:
        for line in axes.get_lines():
            time = line.get_xdata()
            assert np.flatnonzero(np.isnan(time)).tolist() == [2000, 2038, 14978]
            assert np.isnan(line.get_ydata()[[2000, 2038, 14978]]).all()
            assert np.nanmax(np.diff(time)) < 3e-4
    for size in (0, 1, 2):
        assert [len(one) for one in broken(np.arange(size) * 1.0, np.zeros(size))] == [size, size]


_PEAK = """
import resource, sys
from time import perf_counter
from imo_analysis import cli
begun = perf_counter()
assert cli.main(["replay", sys.argv[1], "--machine", sys.argv[2], "--gaps", "bridge", "--window", "0.0002"]) == 0
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, perf_counter() - begun)
"""


@pytest.mark.slow
def test_many_gaps_make_it_neither_large_nor_slow(tmp_path):
    """A million samples at 100 kHz, with a gap behind every fifty, long and short by turns, against the same without."""
    pa = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    pytest.importorskip("resource")
    rows = steady(10.0, 1e5)
    far, number = rows.copy(), np.arange(len(rows))
    far[:, 0] += 5e-3 * (number // 100) + 2e-5 * ((number + 50) // 100)
    turn = np.exp(1j * 205.0 * (far[:, 0] - rows[:, 0]))
    for k in (1, 3):
        pair = (rows[:, k] + 1j * rows[:, k + 1]) * turn
        far[:, k], far[:, k + 1] = pair.real, pair.imag
    found = []
    for path, kept in ((tmp_path / "whole.parquet", rows), (tmp_path / "gaps.parquet", far)):
        parquet.write_table(pa.table(dict(zip(HEADER.split(","), kept.T, strict=True))), path)
        call = [sys.executable, "-c", _PEAK, str(path), machine_file(tmp_path)]
        subprocess.run(call, capture_output=True, check=True)  # compiles
        done = subprocess.run(call, capture_output=True, text=True, check=True)
        found.append([float(one) for one in done.stdout.split()[-2:]])
    assert "9999 gap(s) of up to 0.00501 s" in done.stdout and "10000 gap(s) of up to 3e-05 s bridged" in done.stdout
    assert "20000 stretches between gaps" in done.stdout
    assert found[1][0] < 1.2 * found[0][0] and found[1][1] < 2 * found[0][1]
