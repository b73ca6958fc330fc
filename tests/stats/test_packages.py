"""What packages do rightly is done with them; what not, each with the number that shows it."""

import warnings

import numpy as np
import pytest
from scipy.stats import chi2

from tests.support.packages import BEGIN, CASES, END, difference
from tests.support.published import published
from tests.support.reference_table import PAGE
from vrcomfort.stats.anova import anova
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.packages import quiet


@pytest.mark.parametrize("case", [pytest.param(c, id=f"{c.function}-{c.quantity}") for c in CASES])
@pytest.mark.filterwarnings("ignore::DeprecationWarning:pingouin")
def test_a_package_is_used_where_it_is_right_and_only_there(case):
    off = difference(case)
    assert (off is not None and off <= 1e-6) == case.used
    assert case.used != bool(case.reason)


def test_the_page_has_every_case():
    text = PAGE.read_text("utf-8").partition(BEGIN)[2].partition(END)[0]
    lines = [line.split(" | ")[:2] for line in text.splitlines() if line.startswith("| ")][1:]
    assert lines == [[f"| {case.function}", case.quantity] for case in CASES]


def test_warnings_about_the_insides_of_packages_are_kept_out_and_others_not():
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        with quiet():
            for module in ("pingouin.parametric", "vrcomfort.stats.anova"):
                warnings.warn_explicit("old", DeprecationWarning, "file.py", 1, module=module)
            warnings.warn_explicit("data", RuntimeWarning, "file.py", 1, module="pingouin.power")
    assert [str(w.message) for w in heard] == ["old", "data"]


def test_holm_of_fewer_than_two_tests_is_what_it_was():
    assert holm([]) == []
    assert holm([None, 0.03, None]) == [None, 0.03, None]


def test_p_of_mauchly_in_larger_designs_is_not_that_of_car():
    """car (3.1) has the number of cells, 15, in one term where that of contrasts, 4, belongs."""
    cells = published("obk.long").groupby(["id", "phase", "hour"])["value"].mean().reset_index()
    result = anova(cells, value="value", participant="id", within=["phase", "hour"])
    shape = next(e.sphericity for e in result.effects if e.effect == "hour")

    def p_of(term: int) -> float:
        n, p, w = 15, 4, shape.mauchly_w
        rho = 1 - (2 * p**2 + p + 2) / (6 * p * n)
        omega = (p + 2) * (p - 1) * (p - 2) * (2 * p**3 + 6 * p**2 + 3 * term + 2)
        omega /= 288 * (n * p * rho) ** 2
        first, second = (chi2.sf(-n * rho * np.log(w), df) for df in (9, 13))
        return float(first + omega * (second - first))

    assert shape.mauchly_p == pytest.approx(p_of(4), rel=1e-9)
    assert p_of(15) == pytest.approx(0.000717649646670613, rel=1e-6), "what car prints"
