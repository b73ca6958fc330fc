"""Against R and NIST: data sets of our own that R was run on once (tests/data/oracles).

One test is one analysis of all its data sets. Nothing here needs R.
"""

import hashlib
from collections import defaultdict
from fractions import Fraction

import pytest

from tests.support.oracles import DATA, OURS, SECOND_AUTHORITY, r_output
from tests.support.published import NIST_TOLERANCES, QUANTITIES, certified, nist_data, ours_of_nist
from vrcomfort.stats.signed_rank import signed_rank


def closeness(row: dict[str, str]) -> dict[str, float]:
    quantity = row["quantity"].rpartition(" ")[2]
    if quantity.startswith("partial_eta_squared_"):
        return {"rel": 1e-6, "abs": 1e-9}  # R's noncentral beta stops adding at 1e-9
    return {"rel": 1e-6, "abs": 0}


def values_of_r() -> dict[str, list[dict[str, str]]]:
    """Return analysis → the rows of R's output."""
    found: dict[str, list[dict[str, str]]] = defaultdict(list)
    for row in r_output():
        found[row["analysis"]].append(row)
    return found


def is_ours(row: dict[str, str]) -> bool:
    quantity = SECOND_AUTHORITY.sub("", row["quantity"])
    found = OURS[row["analysis"]](row["dataset"])[quantity]
    if not row["value"]:
        return found is None
    expected = float(row["value"])
    if quantity.endswith(": huynh_feldt"):
        expected = min(expected, 1.0)  # R prints what it then takes for 1
    return bool(found == pytest.approx(expected, **closeness(row)))


@pytest.mark.parametrize("rows", [pytest.param(rows, id=i) for i, rows in values_of_r().items()])
def test_our_values_are_those_of_r(rows, record_property):
    assert [row for row in rows if not is_ours(row)] == []
    record_property("values", len(rows))


def test_r_was_run_on_the_data_that_are_here():
    session = (DATA / "r_session.txt").read_text(encoding="utf-8")
    read = dict(line.split()[::-1] for line in session.partition("MD5 sums")[2].splitlines()[1:])
    here = {path.name: path for path in DATA.glob("*.csv") if path.name != "r_output.csv"}
    assert read == {
        name: hashlib.md5(path.read_bytes(), usedforsecurity=False).hexdigest()
        for name, path in here.items()
    }


def test_no_pairs_give_no_test():
    """R refuses to test nothing; ours says that there is nothing."""
    test = signed_rank([])
    assert (test.n, test.z, test.p, test.shift, test.effect) == (0, None, 1.0, None, None)


# --- NIST ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NIST_TOLERANCES)
def test_one_way_anova_gives_what_nist_certifies(name, record_property):
    ours = {quantity: ours_of_nist(name)[quantity] for quantity in QUANTITIES}
    assert ours == pytest.approx(certified(name), rel=NIST_TOLERANCES[name])
    record_property("values", len(ours))


@pytest.mark.parametrize("name", ["SiRstv", "SmLs09"])
def test_f_is_exact_for_the_numbers_that_were_read(name):
    """Fractions lose nothing: what they give is all that is left of the digits of the file."""
    groups = [[Fraction(y) for y in values] for _, values in nist_data(name).groupby("group")["y"]]
    n, means = sum(map(len, groups)), [sum(g) / len(g) for g in groups]
    grand = sum(map(sum, groups)) / n
    between = sum(len(g) * (m - grand) ** 2 for g, m in zip(groups, means, strict=True))
    within = sum((y - m) ** 2 for g, m in zip(groups, means, strict=True) for y in g)
    f = (between / (len(groups) - 1)) / (within / (n - len(groups)))
    assert ours_of_nist(name)["f"] == pytest.approx(float(f), rel=1e-12)
