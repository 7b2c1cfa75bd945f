"""An observer's file: what is refused, and with which words; what it is called; whether it follows the machine."""

import os
from fractions import Fraction

import numpy as np
import pytest
from own_files import ADAPTED, HEAD, TAIL, copy_of, own_text

from imo_analysis.equations import own, plain
from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.machine import PRESETS
from imo_analysis.notation import symbol
from imo_analysis.pencils.error import OperatingPoint, poles_at
from imo_analysis.pencils.jacobian import derive
from imo_analysis.pencils.own import check_derivative, departures, size_of


def written(tmp_path, text, name="mine.py"):
    """The kind of a file with this text."""
    place = tmp_path / name
    place.write_text(text, encoding="utf-8")
    return own.located(name, tmp_path)


def lines(*body):
    return "".join(f"    {line}\n" for line in body)


@pytest.mark.parametrize(("text", "said"), [
    ("def rates(:\n", "line 1: SyntaxError: invalid syntax"),
    ("import nothing_of_this_name\n", "line 1: ModuleNotFoundError: No module named 'nothing_of_this_name'"),
    ("\n1 / 0\n", "line 2: ZeroDivisionError: division by zero"),
    ("raise SystemExit\n", "line 1: SystemExit: no more is said"),
    ("x = 1\n", "has no OBSERVER; end it with OBSERVER = Observer(name=..."),
    ("OBSERVER = 7\n", "has OBSERVER = '7'; end it with"),
    (own_text(lines("return x[:5]")), "rates returns 5 values; it must return a tuple of 6: i_ds_hat, i_qs_hat"),
    (own_text(lines("return x[0]")), "rates returns a float; it must return a tuple of 6"),
    (own_text(lines("return [0, 0, 0, 0, 0, 0]")), "line 10: rates has a list; write a tuple, (a, b)"),
    (own_text(lines("if x[0] > 0:", "    return x", "return x")), "line 10: rates has an if; write max(v, 0) as (v + abs"),
    (own_text(lines("s = 1 if x[0] > 0 else 0", "return x")), "line 10: rates has an if; write max(v, 0)"),
    (own_text(lines("a = 0", "for k in range(3):", "    a += x[k]", "return x")), "line 11: rates has a loop; write"),
    (own_text(lines("return (*x[:5], sum(x))")), "line 10: rates has sum(...), which is no such function of this file"),
    (own_text(lines("return (*x[:5], math.sin(x[4]))"), "import math\n" + HEAD), "line 11: rates has math.sin(...), which"),
    (own_text(lines("return (*x[:5], sin(x[4]))"), "from math import sin\n" + HEAD), "line 11: rates has sin(...), which"),
    (own_text(lines("return (*x[:5], x[4] ** 0.5)")), "line 10: rates has a power that is not a whole number from 1 to 64"),
    (own_text(lines("return (*x[:5], x[4] ** -1)")), "write 1/x for x**-1"),
    (own_text(lines("return (*x[:5], omega)")), "line 10: rates has omega, which is neither an"),
    (own_text(lines("return (*x[:5], x[9])")), "line 10: rates cannot be called with ordinary numbers: IndexError"),
    (own_text(lines("return (*x[:5], x[4] / (x[3] - x[3]))")), "cannot be called with ordinary numbers: ZeroDivisionError"),
    (own_text(lines("return (*x[:5], N)"), "N = float('nan')\n" + HEAD),
     "rates gives nan for R_s_shift at ordinary numbers; it must be finite"),
    (own_text(lines("return (*x[:5], direction)")), "rates depend on direction; say so with needs_direction=True"),
    (own_text(lines("return (*x[:5], x[4] / (i[0] - x[0]))")), "divide by zero where its estimates are right"),
    (own_text(tail=TAIL.replace("rates=rates", "rates=lambda x, i, u, direction, p, gains: x")), "<lambda> comes from"),
    (own_text(tail=TAIL.replace("rates=rates", "rates=abs")), "rates = <built-in function abs> must be a function of"),
    (own_text(tail=TAIL.replace("rates=rates", "rates=flux")), "line 5: flux takes 3 arguments; rates takes 6: (x, i, u"),
    (own_text(tail=TAIL.replace('"omega_hat", ', '"w", ')), "phi_qr_hat, w, R_s_shift lack omega_hat, the estimate of"),
    (own_text(tail=TAIL.replace('"i_ds_hat"', '"i_ds"')), "state i_ds is a name of the machine or of a run; its estimate"),
    (own_text(tail=TAIL.replace('gains=("l_1"', 'gains=("R_s"')), "gain R_s is a name of the machine or of a run"),
    (own_text(tail=TAIL.replace('"phi_dr_hat", "phi_qr_hat"', '"psi_ds_hat", "psi_qs_hat"')), "write z_1_hat, z_2_hat,"),
    (own_text(tail=TAIL.replace('"l_2"', '"l_1"')), "l_1 is there twice among states and gains"),
    (own_text(tail=TAIL.replace('name="mine"', 'name="repaired"')), "name = 'repaired' is an observer of the catalogue"),
    (own_text(tail=TAIL.replace('name="mine"', 'name="a/b"')), "name = 'a/b' must be 1 to 60 letters"),
    (own_text(tail=TAIL.replace('"a test"', '"two\\nlines"')), "source = 'two\\nlines' must be one line of 1 to 200"),
    (own_text(tail=TAIL.replace('"a test"', '"$x$"')), "source = '$x$' must be one line of 1 to 200 characters, without"),
    (own_text(tail=TAIL.replace(', "h_R": "ohm/(A^2 s)"', "")), "h_R is not in the notation; say its unit, units={"),
    (own_text(tail=TAIL.replace("ohm/(A^2 s)", "ohms")), "unit 'ohms': cannot read 'ohms'"),
    (own_text(tail=TAIL.replace('{"R_s_shift"', '{"l_1": "ohm", "R_s_shift"')), "l_1 in 'ohm'; it is in '1/s' everywhere"),
    (own_text(tail=TAIL.replace('{"R_s_shift"', '{"q": "ohm", "R_s_shift"')), "units has 'q', which is neither a state nor"),
])
def test_a_file_that_cannot_be_used_is_refused_in_one_line_that_names_it(tmp_path, text, said):
    kind = written(tmp_path, text)
    with pytest.raises(InputError) as fault:
        OBSERVERS[kind]
    assert said in str(fault.value) and str(tmp_path / "mine.py") in str(fault.value) and "\n" not in str(fault.value)


def test_a_file_that_is_not_there_or_is_no_longer_the_same_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the observer .*gone\.py: No such file"):
        own.located("gone.py", tmp_path)
    kind = written(tmp_path, own_text())
    written(tmp_path, own_text(ADAPTED + "\n"))
    with pytest.raises(InputError, match=rf"has changed: the hash of its text now begins with \w+, .* has {kind[-12:]};"):
        OBSERVERS[kind]
    with pytest.raises(InputError, match=r"is a file, which may change; give located\('mine.py'\)"):
        OBSERVERS["mine.py"]
    with pytest.raises(InputError, match=r"observer = 'kalman' is not known; choose one of: baseline, .*; or a file of your"):
        OBSERVERS["kalman"]


def test_what_is_loaded_stays_what_it_was_and_equal_names_do_not_meet(tmp_path):
    """A changed file is another observer; two files of one name are two; going through the catalogue does not meet any."""
    first = written(tmp_path, own_text())
    before = OBSERVERS[first]
    changed = written(tmp_path, own_text(ADAPTED.replace("-gains[5]", "-2 * gains[5]")))
    (tmp_path / "other").mkdir()
    elsewhere = written(tmp_path / "other", own_text(ADAPTED.replace("-gains[5]", "-3 * gains[5]")))
    numbers = ((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), (2.0, 3.0), (4.0, 5.0), 1.0, (1.0, 2.0, 3.0, 4.0, 5.0), (1.0,) * 6)
    found = [OBSERVERS[kind].rates(*numbers)[5] for kind in (first, changed, elsewhere)]
    assert found[1] == 2 * found[0] and found[2] == 3 * found[0] and OBSERVERS[first] is before
    assert len({first, changed, elsewhere}) == 3 and not [kind for kind in OBSERVERS if own.is_file(kind)]
    assert own.shown(elsewhere) == "mine.py" and own.shown("repaired") == "repaired"


def test_a_path_is_relative_to_the_folder_that_is_given_and_written_out_whole(tmp_path, monkeypatch):
    kind = written(tmp_path, own_text())
    monkeypatch.chdir(tmp_path)
    assert kind == own.located("mine.py") == own.located(kind, tmp_path / "anywhere") and os.path.isabs(kind)
    assert own.located("repaired", tmp_path) == "repaired"


def test_names_that_the_notation_lacks_have_the_unit_of_the_file(tmp_path):
    OBSERVERS[written(tmp_path, own_text())]
    assert symbol("h_R").unit == "ohm/(A^2 s)" and symbol("h_R").latex == "h_{R}"
    assert symbol("R_s_shift_tilde").unit == "ohm"
    with pytest.raises(InputError, match=r"other.py: h_R is in '1/s', and .*mine.py has it in 'ohm/\(A\^2 s\)'; give"):
        OBSERVERS[written(tmp_path, own_text(tail=TAIL.replace("ohm/(A^2 s)", "1/s")), "other.py")]


# At zero error ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("change", "off"), [
    (("-gains[5] * along", "-gains[5] * along"), {}),
    (("(R_s + x[5],", "(2 * R_s + x[5],"), {"i_ds_hat": "-R_s*i_ds/sigma", "i_qs_hat": "-R_s*i_qs/sigma"}),
    (("-gains[5] * along", "1 - gains[5] * along"), {"R_s_shift": "1"}),
    (("(*adapted,", "(*adapted[:3], -adapted[3], adapted[4],"),
     {"phi_qr_hat": "-2*(L_m*alpha*i_qs - alpha*phi_qr + omega*phi_dr)"}),
    (("(*adapted,", "(*adapted[:4], adapted[4] + 0.1 * x[4],"), {"omega_hat": "omega/10"}),
])
def test_rows_in_which_right_estimates_leave_the_machine_are_found_twice(tmp_path, recwarn, change, off):
    """In symbols, and with numbers and another form of the machine; the symbols, put into numbers, are the difference."""
    kind = written(tmp_path, own_text(ADAPTED.replace(*change)))
    observer = OBSERVERS[kind]
    said = [str(one.message) for one in recwarn if "with right parameters" in str(one.message)]
    assert {row: str(rest) for row, rest in departures(kind).items()} == off
    assert own.astray(observer) == list(off)
    assert len(said) == bool(off) and all(row in said[0] for row in off)


@pytest.mark.filterwarnings("ignore:.*flux_q leaves the machine")
def test_a_flux_estimate_of_the_wrong_sign_is_found(tmp_path):
    kind = written(tmp_path, own_text(head=HEAD.replace("return x[2], x[3]", "return x[2], -x[3]")))
    found = departures(kind)
    assert {row: str(rest) for row, rest in found.items()} == {"flux_q": "-2*phi_qr"}
    assert own.astray(OBSERVERS[kind]) == ["flux_q"]
    point, p = OperatingPoint(30.0, 0.5, 0.0), (0.4, 0.06, 0.005, 200.0, 10.0)
    gains = dict.fromkeys(OBSERVERS[kind].gains, 1.0)
    assert size_of(found["flux_q"], kind, gains, p, point) == pytest.approx(2 * 0.5 / 2**0.5)


@pytest.mark.parametrize("name", list(OBSERVERS))
def test_the_catalogue_follows_and_its_derivatives_agree(name):
    assert departures(name) == {} and own.astray(OBSERVERS[name]) == [] and check_derivative(name) > 100


def test_a_derivative_that_is_wrong_is_noticed(tmp_path, monkeypatch):
    from imo_analysis.pencils import own as module

    kind = written(tmp_path, own_text())
    right = derive(kind, "frozen")
    assert check_derivative(kind) == 196
    broken = right.matrix.copy()
    broken[2, 3] += right.matrix[2, 3]
    monkeypatch.setattr(module, "derive", lambda name, which: type(right)(**{**vars(right), "matrix": broken}))
    with pytest.raises(AssertionError, match=r"mine: entry 2, 3 of its frozen dynamics is .* by differentiation and"):
        check_derivative(kind)


def test_an_observer_without_currents_and_gains_has_the_machine_s_own_poles(tmp_path):
    """The rotor equation run beside the machine: -alpha +- j omega at known speed, and an R_s_hat that decays with 1/s."""
    text = ("from imo_analysis.equations.catalogue import Observer\nfrom imo_analysis.equations.plant import plant\n\n\n"
            "def rates(x, i, u, direction, p, gains):\n    whole = plant((*i, *x[:3]), u, 0, 0, (*p, 0, 0, 1))\n"
            "    return (*whole[2:4], 0, p[0] - x[3])\n\n\ndef flux(x, i, beta):\n    return x[:2]\n\n\n"
            "OBSERVER = Observer('open', rates, ('phi_dr_hat', 'phi_qr_hat', 'omega_hat', 'R_s_hat'), (), flux, 'a', 'b')\n")
    kind = written(tmp_path, text)
    machine, point = PRESETS["table-iii"], OperatingPoint(50.0, 0.5, 2.0)
    assert departures(kind) == {} and check_derivative(kind) > 50
    np.testing.assert_allclose(poles_at(machine, kind, {}, point), [-machine.alpha - 50j, -machine.alpha + 50j])
    full = poles_at(machine, kind, {}, point, "full")
    np.testing.assert_allclose(full, [-machine.alpha - 2j, -machine.alpha + 2j, -1.0, 0.0], atol=1e-12)


def test_decimal_numbers_become_fractions_in_functions_and_in_constants():
    space = {"SHARE": 0.1, "PAIR": (0.5, 2)}
    exec("def inner(v):\n    return v * SHARE\ndef outer(v):\n    return inner(v) + 0.25 * v + PAIR[0] * PAIR[1]\n", space)
    assert plain.exact(space["outer"])(Fraction(1)) == Fraction(1, 10) + Fraction(1, 4) + 1
    assert space["outer"](1.0) == 1.35


@pytest.mark.parametrize("kind", ["baseline", "repaired", "supervised"])
def test_a_copy_of_an_observer_of_the_catalogue_is_taken(tmp_path, kind):
    found = OBSERVERS[written(tmp_path, copy_of(kind, f"{kind} copied"))]
    assert found.states == OBSERVERS[kind].states and own.astray(found) == []
