"""Reading logs: columns, units, faults by name and line, and two readers that give the same bits."""

import math
from pathlib import Path

import numpy as np
import pytest
from replay_records import HEADER, steady, write

from imo_analysis.errors import InputError
from imo_analysis.replay import logs
from imo_analysis.replay.columns import choose, recognise
from imo_analysis.replay.logs import Log
from imo_analysis.replay.survey import survey


@pytest.mark.parametrize(
    ("name", "role", "unit"),
    [
        ("t_s", "time", "s"), ("Time [ms]", "time", "ms"), ("time", "time", None), ("va_V", "u_a", "V"), ("U_b", "u_b", None),
        ("Vab (kV)", "u_ab", "kV"), ("u_alpha", "u_d", None), ("u_ds", "u_d", None), ("ia_A", "i_a", "A"),
        ("Ib [mA]", "i_b", "mA"), ("i_beta", "i_q", None), ("i_qs_meas", "i_q", None),
        ("speed_rad_per_s", "omega_m", "rad/s"), ("n_rpm", "omega_m", "rpm"), ("rpm", "omega_m", "rpm"),
        ("omega", "omega", None), ("omega_m", "omega_m", None),
        ("U1 (V)", "u_a", "V"), ("I3 (mA)", "i_c", "mA"), ("I_L2 [A]", "i_b", "A"), ("U_L1L2", "u_ab", None),
        ("u31", "u_ca", None),
        ("Zeit/ms", "time", "ms"), ("U_a/V", "u_a", "V"), ("I_b / mA", "i_b", "mA"), ("ms", "time", "ms"), ("vU", "u_a", None),
        ("vV", "u_b", None), ("vW", "u_c", None), ("iV", "i_b", None), ("U_V", "u_b", None), ("U_UV", "u_ab", None),
        ("n/min^-1", "omega_m", "min^-1"), ("Drehzahl/(1/min)", "omega_m", "1/min"), ("t [sec]", "time", "s"),
    ],
)
def test_usual_names_are_known(name, role, unit):
    assert recognise(name) == (role, unit)


@pytest.mark.parametrize("name", ["i_ds_hat", "torque", "phi_dr", "idc", "vdc", "temperature", "va_mA", "", "UV", "uw", "VW"])
def test_other_names_are_not(name):
    assert recognise(name) is None


def test_flags_go_before_names():
    header = ["t", "x1", "x2", "ia", "ib", "ic", "w"]
    chosen = choose(header, {"ua": "x1", "ub": "x2", "i_c": "none", "omega": "w"}, {"current": "mA", "w": "rpm"}, "log")
    assert [c.role for c in chosen] == ["time", "u_a", "u_b", "i_a", "i_b", "omega"]
    assert [c.unit for c in chosen] == ["s", "V", "V", "mA", "mA", "rpm"]


@pytest.mark.parametrize(
    ("header", "columns", "units", "words"),
    [
        ("t,ua,ub,ia", {}, {}, "not enough currents"),
        ("t,ia,ib,ic", {}, {}, "not enough voltages"),
        ("ua,ub,ia,ib", {}, {}, "no time column"),
        ("t,time,ua,ub,ia,ib", {}, {}, "all look like time"),
        ("t,ua,ub,ia,ib", {"ia": "Ch1"}, {}, "no column 'Ch1'"),
        ("t,ua,ub,ia,ib", {"flux": "ua"}, {}, "is not something"),
        ("t,ua,ub,ia,ib", {}, {"current": "V"}, "choose one of: A, mA, kA"),
        ("t,ua,ub,ia,ib", {}, {"torque": "V"}, "is not something"),
    ],
)
def test_wrong_columns_are_named(header, columns, units, words):
    with pytest.raises(InputError, match=words):
        choose(header.split(","), columns, units, "log")


def _values(path: Path, **more):
    block = next(Log.open(path, 2, **more).blocks())
    return np.column_stack([block.u_ds, block.u_qs, block.i_ds, block.i_qs, block.omega])


def test_phases_lines_and_axes_give_the_same(tmp_path):
    rows = steady(0.01)
    turn = np.exp(-2j * np.pi / 3 * np.arange(3))
    u, i = (rows[:, 1] + 1j * rows[:, 2], rows[:, 3] + 1j * rows[:, 4])
    phases = np.column_stack([(x[:, None] * turn).real for x in (u, i)])
    lines = phases[:, :3] - np.roll(phases[:, :3], -1, axis=1)
    time, omega = rows[:, :1], rows[:, 5:]
    expected = rows[:, 1:]
    three = write(tmp_path / "3.csv", np.hstack([1e3 * time, phases + np.repeat([5.0, 0.0], 3), omega / 2]),
                  "t_ms,ua,ub,uc,ia,ib,ic,speed")
    two = write(tmp_path / "2.csv", np.hstack([time, phases[:, [0, 2]], phases[:, [4, 5]], omega]), "t,ua,uc,ib,ic,omega")
    line = write(tmp_path / "l.csv", np.hstack([time, lines[:, 1:], 1e3 * phases[:, 3:], omega / 2 * 30 / np.pi]),
                 "t,ubc,uca,ia_mA,ib_mA,ic_mA,n_rpm")
    all_lines = write(tmp_path / "l3.csv", np.hstack([1e3 * time, lines, phases[:, 3:], omega / 2 * 30 / np.pi]),
                      "t_ms,Uab_V,Ubc_V,Uca_V,Ia_A,Ib_A,Ic_A,n_rpm")
    off = write(tmp_path / "l3off.csv", np.hstack([time, lines + 3.0, phases[:, 3:], omega / 2]),
                "t,uab,ubc,uca,ia,ib,ic,speed")
    named = _values(all_lines, columns={"uab": "Uab_V", "ubc": "Ubc_V"})
    assert np.array_equal(named, _values(all_lines))
    for path in (three, two, line, all_lines, off):
        assert np.allclose(_values(path), expected, rtol=1e-12, atol=1e-12)


def test_the_unit_in_the_header_counts_for_a_column_that_is_named(tmp_path):
    chosen = choose(["Ch0 (ms)", "Ch1 [kV]", "Ch2/V", "Ch3 (mA)", "Ch4"],
                    {"time": "Ch0 (ms)", "ua": "Ch1 [kV]", "ub": "Ch2/V", "ia": "Ch3 (mA)", "ib": "Ch4"}, {}, "log")
    assert [column.unit for column in chosen] == ["ms", "kV", "V", "mA", "A"]


@pytest.mark.parametrize("reader", ["pyarrow", "numpy"])
def test_decimal_commas_between_semicolons(tmp_path, monkeypatch, reader):
    if reader == "numpy":
        monkeypatch.setattr(logs, "find_spec", lambda name: None)
    rows = steady(0.01)
    path = write(tmp_path / "a.csv", rows)
    path.write_text(path.read_text().replace(",", ";").replace(".", ","))
    assert np.array_equal(_values(path), rows[:, 1:])
    path.write_text(path.read_text().replace("0,0001;", "0,0001;x", 1))
    with pytest.raises(InputError, match="line 3: u_alpha = 'x"):
        survey(Log.open(path, 2))


def test_two_readers_give_the_same_bits(tmp_path, monkeypatch):
    path = write(tmp_path / "a.csv", steady(0.05))
    fast = _values(path)
    monkeypatch.setattr(logs, "find_spec", lambda name: None)
    assert np.array_equal(_values(path), fast)
    assert np.array_equal(fast, steady(0.05)[:, 1:])


def test_parquet_gives_the_same_bits(tmp_path):
    pa = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    rows = steady(0.05)
    parquet.write_table(pa.table(dict(zip(HEADER.split(","), rows.T, strict=True))), tmp_path / "a.parquet", row_group_size=77)
    assert np.array_equal(_values(tmp_path / "a.parquet"), rows[:, 1:])
    rows[30, 3] = math.nan
    parquet.write_table(pa.table(dict(zip(HEADER.split(","), rows.T, strict=True))), tmp_path / "b.parquet")
    with pytest.raises(InputError, match="row 31: i_alpha has no finite value"):
        survey(Log.open(tmp_path / "b.parquet", 2))
    (tmp_path / "c.parquet").write_text(HEADER)
    with pytest.raises(InputError, match="not a Parquet file"):
        Log.open(tmp_path / "c.parquet", 2)


def test_semicolons_comments_quotes_and_a_byte_order_mark(tmp_path):
    rows = steady(0.01)
    text = "\ufeff# from a drive\n\n" + ";".join(f'"{name}"' for name in HEADER.split(",")) + "\r\n"
    text += "\r\n".join("; ".join(repr(float(v)) for v in row) for row in rows) + "\r\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    assert np.array_equal(_values(tmp_path / "a.csv"), rows[:, 1:])


def _spoilt(tmp_path, change):
    lines = (HEADER + "\n" + "\n".join(",".join(f"{v:.9g}" for v in row) for row in steady(0.02))).split("\n")
    path = tmp_path / "log.csv"
    path.write_text("\n".join(change(lines)) + "\n")
    return path


def _cell(row, column, text):
    def change(lines):
        cells = lines[row - 1].split(",")
        cells[column] = text
        return [*lines[: row - 1], ",".join(cells), *lines[row:]]

    return change


FAULTS = [
    ("nan", _cell(17, 3, "NaN"), r"line 17: i_alpha = 'NaN' is not a number"),
    ("inf", _cell(17, 3, "inf"), r"line 17: i_alpha = 'inf'"),
    ("empty cell", _cell(50, 1, ""), r"line 50: u_alpha is empty"),
    ("text", _cell(101, 2, "open"), r"line 101: u_beta = 'open' is not a number"),
    ("short line", lambda lines: [*lines[:30], "0.1,2", *lines[31:]], r"line 31: 2 columns where the header has 6"),
    ("missing sample", lambda lines: lines[:40] + lines[41:], r"line 41 \(t = 0.004 s\): .*1 sample\(s\) missing"),
    ("ten missing", lambda lines: lines[:40] + lines[50:], r"line 41 .*10 sample\(s\) missing"),
    ("uneven", _cell(60, 0, "0.00583"), r"line 60 .*not evenly spaced"),
    ("backwards", _cell(60, 0, "0.001"), r"line 60 .*time goes back"),
    ("repeated", lambda lines: [*lines[:60], *lines[59:]], r"line 61 .*time repeats"),
    ("one row", lambda lines: lines[:2], "1 row"),
    ("short record", lambda lines: lines[:3], r"2 row\(s\) of data are too short a record; it takes 50 samples or more"),
    ("decimal commas", lambda lines: [lines[0], *(line.replace(".", ",") for line in lines[1:])],
     r"line 2: \d+ columns where the header has 6; are its decimals written with a comma"),
    ("no rows", lambda lines: lines[:1], "0 row"),
    ("empty file", lambda lines: [""], "is empty"),
    ("no header", lambda lines: lines[1:], "holds numbers, not names"),
    ("no columns", lambda lines: ["hello world", "this is a letter"], "one column"),
    ("time in ms",
     lambda lines: [lines[0], *(f"{1e3 * float(row.split(',')[0]):.6g},{row.split(',', 1)[1]}" for row in lines[1:])],
     "unit time=ms"),
    ("no current", lambda lines: [lines[0], *(",".join([*row.split(",")[:3], "0", "0", "0"]) for row in lines[1:])],
     "current is zero in every sample"),
    ("no voltage",
     lambda lines: [lines[0], *(",".join([row.split(",")[0], "0", "0", *row.split(",")[3:]]) for row in lines[1:])],
     "voltage is zero in every sample"),
]


@pytest.mark.parametrize("reader", ["pyarrow", "numpy"])
@pytest.mark.parametrize(("change", "words"), [fault[1:] for fault in FAULTS], ids=[fault[0] for fault in FAULTS])
def test_faults_are_named_with_their_line(tmp_path, monkeypatch, reader, change, words):
    if reader == "numpy":
        monkeypatch.setattr(logs, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=words) as caught:
        survey(Log.open(_spoilt(tmp_path, change), 2))
    assert "\n" not in str(caught.value)


def test_what_is_not_a_log_is_refused(tmp_path):
    (tmp_path / "a.csv").write_bytes(bytes(range(256)) * 40)
    (tmp_path / "b.csv").write_bytes(b"time,ua,ub,ia,ib\n0,1,2,3,4\n" + b"\xff\xfe,1,2,3,4\n")
    for name in ("a.csv", "b.csv", ".", "missing.csv"):
        with pytest.raises(InputError):
            survey(Log.open(tmp_path / name, 2))


def test_a_column_that_is_there_twice_is_refused(tmp_path):
    path = write(tmp_path / "a.csv", steady(0.01)[:, [0, 1, 2, 3, 3, 4]], "time,u_alpha,u_beta,i_alpha,i_alpha,i_beta")
    with pytest.raises(InputError, match="i_alpha"):
        Log.open(path, 2)


def test_unused_columns_may_hold_anything(tmp_path):
    path = _spoilt(tmp_path, lambda lines: [lines[0] + ",state", *(line + ",run" for line in lines[1:])])
    assert survey(Log.open(path, 2)).rows == 200


def test_currents_that_do_not_add_up_are_named(tmp_path):
    rows = steady(0.02)
    i = rows[:, 3] + 1j * rows[:, 4]
    phases = (i[:, None] * np.exp(-2j * np.pi / 3 * np.arange(3))).real * [1, 1, -1]
    path = write(tmp_path / "a.csv", np.hstack([rows[:, :3], phases]), "t,u_alpha,u_beta,ia,ib,ic")
    with pytest.raises(InputError, match="do not add up to zero"):
        survey(Log.open(path, 2))
    assert survey(Log.open(path, 2, {"i_c": "none"})).rows == 200


@pytest.mark.parametrize("rate", [1e8, 10.0])
def test_impossible_rates_are_refused(tmp_path, rate):
    rows = steady(0.01)
    rows[:, 0] = np.arange(len(rows)) / rate
    with pytest.raises(InputError, match="Is the unit of time right"):
        survey(Log.open(write(tmp_path / "a.csv", rows), 2))
    with pytest.raises(InputError, match="200 Hz to 20 MHz"):
        survey(Log.open(write(tmp_path / "a.csv", rows), 2, rate=rate))


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf])
def test_a_rate_must_be_a_rate(tmp_path, rate):
    with pytest.raises(InputError, match="must be above 0 Hz"):
        Log.open(write(tmp_path / "a.csv", steady(0.01)), 2, rate=rate)


def test_a_rate_stands_in_for_rounded_times(tmp_path):
    rows = steady(0.02)
    rows[:, 0] = np.floor(rows[:, 0] * 1e3) / 1e3
    path = write(tmp_path / "a.csv", rows)
    with pytest.raises(InputError, match="give --rate"):
        survey(Log.open(path, 2))
    assert survey(Log.open(path, 2, rate=1e4)).sample_time == 1e-4


def test_gaps_are_bridged_only_when_asked(tmp_path):
    path = _spoilt(tmp_path, lambda lines: lines[:40] + lines[45:])
    assert survey(Log.open(path, 2), bridge=True).gaps == 1
    with pytest.raises(InputError, match="bridge"):
        survey(Log.open(path, 2))


def test_blocks_of_any_size_hold_the_same_rows(tmp_path):
    path = write(tmp_path / "a.csv", steady(0.05))
    whole = next(Log.open(path, 2).blocks())
    for rows in (1, 7, 499, 500, 501):
        parts = list(Log.open(path, 2).blocks(rows))
        assert [len(part) for part in parts[:-1]] == [rows] * (len(parts) - 1)
        assert np.array_equal(np.concatenate([part.u_ds for part in parts]), whole.u_ds)
        assert [part.first for part in parts] == list(range(0, 500, rows))
