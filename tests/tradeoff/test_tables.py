"""What follows from the numbers: means, fronts, verdicts and dials, in words."""

import pytest

from vrcomfort.tradeoff import results, tables
from vrcomfort.tradeoff.measure import SCATTER

SCENE = {"scene": "hall", "effect": "depth_of_field", "pose": 0, "motion": "still", "lens": "7"}
REST = {
    **dict.fromkeys((*results.MEANS, *results.QUADRATIC), 0.01),
    **dict.fromkeys(results.COSTS, 1.0),
    **dict.fromkeys(results.COUNTS, 3),
    "samples": 64,
    "shower_door": -0.5,
}


def row(method, family, cost, rms, *, step=None, rivalry=0.01, **more):
    own = {"method": method, "family": family, "step": step, "cost": cost, "rms": rms}
    return {**SCENE, **REST, **own, "reference_rms": 0.001, "rivalry": rivalry, **more}


ROWS = [
    row(SCATTER, "none", None, 0.01, rivalry=0.02),
    row("no blur", "none", 1.0, 0.2),
    row("mip", "source", 10.0, 0.05, rivalry=0.04),
    row("scatter", "source", 100.0, 0.005, rivalry=0.03),
    row("ours 1 ring", "ours", 5.0, 0.04, step=1, rivalry=0.05),
    row("ours 2 rings", "ours", 50.0, 0.02, step=2, rivalry=0.024),
]


@pytest.fixture
def found():
    table = results.means(ROWS)
    return {"table": table, **results.compared(table)}


def test_means_over_views_are_quadratic_for_rms():
    twice = [row("a", "ours", 2.0, 0.03), row("a", "ours", 4.0, 0.04)]
    (mean,) = results.means(twice)
    assert mean["rms"] == pytest.approx((0.0025 / 2) ** 0.5)
    assert mean["psnr_db"] == pytest.approx(29.03, abs=0.01)
    assert (mean["cost"], mean["views"]) == (3.0, 2)
    assert mean["wide_px"] == 6
    assert mean["counts"]
    assert mean["split_half"] == pytest.approx(0.001 / mean["rms"])


def test_verdicts_say_who_is_both_faster_and_closer(found):
    rows = [
        [show(v) for _, show in tables.VERDICT_COLUMNS]
        for v in found["verdicts"]
        if v["error"] == "rms" and v["price"] == "cost"
    ]
    hall = "hall, depth of field, lens 7 %"
    assert rows[0] == [hall, "mip", "RMS", "cost", "ours 1 ring", "0.50", "0.80", "yes"]
    unsure = "no: 4.00×, does not count"
    assert rows[1] == [hall, "scatter", "RMS", "cost", "ours 2 rings", "0.50", "4.0", unsure]
    assert "in 1 of 8 by cost, 0 of 8 by reads, 0 of 8 by bytes" in tables.headline(found)


def test_reads_and_bytes_have_verdicts_of_their_own():
    """`ours` is dearer in time, cheaper in reads, and moves as many bytes."""
    rows = [
        row(SCATTER, "none", None, 0.01),
        row("mip", "source", 1.2, 0.05, reads_per_pixel=20.0, near_rims_rms=0.02),
        row("ours", "ours", 1.5, 0.04, reads_per_pixel=10.0, near_rims_rms=0.03),
    ]
    found = results.compared(results.means(rows))["verdicts"]
    shown = {(v["error"], v["price"]): (v["beaten"], round(v["factor"], 2)) for v in found}
    assert shown["rms", "cost"] == (False, 1.25)
    assert shown["rms", "reads_per_pixel"] == (True, 0.8)
    assert shown["rms", "bytes_per_pixel"] == (False, 1.0)
    assert shown["near_rims_rms", "reads_per_pixel"] == (False, 1.5)
    assert not any(v["undecided"] for v in found if v["price"] != "cost")


def test_what_a_view_has_not_is_in_no_mean_and_no_verdict():
    rows = [
        row("mip", "source", 1.2, 0.05, lamps_rms=None, far_edges_rms=None),
        row("mip", "source", 1.2, 0.05, lamps_rms=0.3, far_edges_rms=None),
        row("ours", "ours", 1.5, 0.04, far_edges_rms=None),
    ]
    table = results.means(rows)
    assert table[0]["lamps_rms"] == pytest.approx(0.3)
    assert table[0]["far_edges_rms"] is None
    assert "far_edges_rms" not in {v["error"] for v in results.compared(table)["verdicts"]}


def test_the_headline_says_what_counts_and_what_noise_could_turn():
    """`near` is closer than `mip` at 1.02 of its cost; `sure` is closer, but R1 is too unsure."""
    rows = [
        row(SCATTER, "none", None, 0.01),
        row("mip", "source", 10.0, 0.05, flip=0.05),
        row("scatter", "source", 100.0, 0.009, flip=0.05),
        row("near", "ours", 10.2, 0.04, flip=0.06),
        row("sure", "ours", 50.0, 0.008, flip=0.04),
    ]
    found = results.compared(results.means(rows), (0.97, 1.03))
    last = tables.VERDICT_COLUMNS[-1][1]
    at_cost = [v for v in found["verdicts"] if v["price"] == "cost"]
    shown = {(v["theirs"], v["error"]): last(v) for v in at_cost if v["error"] in {"rms", "flip"}}
    assert shown == {
        ("mip", "rms"): "no: 1.02×, within A/A",
        ("mip", "flip"): "no: 1.20×",
        ("scatter", "rms"): "yes, does not count",
        ("scatter", "flip"): "yes, does not count",
    }
    told = tables.headline(found)
    counting = sum(v["counts"] for v in found["verdicts"])
    assert f"in {counting} of these 24 comparisons both rows count, and in 1 the verdict" in told
    assert 0 < counting < 24
    assert "(0.97–1.03)" in told


def test_methods_that_draw_the_same_are_on_the_front_together():
    rows = [
        *ROWS,
        row("ours 3 rings", "ours", 51.0, 0.02, step=3),
        row("ours 4 rings", "ours", 70.0, 0.02, step=4),
        row("ours 5 rings", "ours", 51.0, 0.0201, step=5),
    ]
    (found,) = results.compared(results.means(rows))["fronts"]
    assert found["front"] == ["ours 1 ring", "ours 2 rings", "ours 3 rings", "scatter"]
    (found,) = results.compared(results.means(rows), (0.7, 1.5))["fronts"]
    assert "ours 4 rings" in found["front"], "a run as noisy as that cannot tell"


def test_a_dial_tells_its_slope_and_where_the_reference_counts(found):
    (line,) = tables.dials(found)
    assert "falls at every step of rings = 1…2; log-log slope -1.0" in line
    assert "R1 counts" not in line
    unsure = [*ROWS, row("ours 4 rings", "ours", 70.0, 0.008, step=4)]
    (dial,) = results.compared(results.means(unsure))["dials"]
    assert dial["steps_that_count"] == [1, 2]
    assert "(-1.0 up to 2, where R1 counts)" in tables.dials({"dials": [dial]})[0]


def test_each_dial_is_told_by_itself():
    rows = [*ROWS, *(row(f"ours {n} taps", "ours", 9.0 * n, 0.1 / n, step=n) for n in (6, 12))]
    found = results.compared(results.means(rows))
    assert [(dial["dial"], dial["steps"]) for dial in found["dials"]] == [
        ("rings", [1, 2]),
        ("taps", [6, 12]),
    ]


def test_equal_errors_have_no_slope_of_rounding():
    rows = [*ROWS, *(row(f"ours {n} taps", "ours", 9.0 * n, 0.07, step=n) for n in (6, 12, 24))]
    found = results.compared(results.means(rows))
    assert abs(found["dials"][1]["slope"]) < 1e-9
    assert tables.dials(found)[1].endswith(": error does not change with taps = 6…24.")


def test_a_slope_says_that_it_rests_on_rows_that_do_not_count():
    sure, unsure = row("ours 1 view", "ours", 9.0, 0.02, step=1), {"step": 4, "counts": False}
    rows = [*ROWS, sure, row("ours 4 views", "ours", 90.0, 0.008, **unsure)]
    line = tables.dials(results.compared(results.means(rows)))[1]
    assert line.endswith("(R1 counts at 1 alone: the slope rests on rows that do not).")


def test_both_eyes_are_compared_with_r2_and_with_the_sources(found):
    line, hint = tables.both_eyes(found)
    assert "rivalry of *ours 2 rings* is 1.2 × that of R2 and 0.80 × the least" in line
    assert "shower door -0.50 (R2 -0.50)" in line
    assert "at this size" in hint


@pytest.mark.parametrize(("high", "doubted"), [(1.09, False), (1.11, True)])
def test_costs_are_doubted_where_the_same_work_twice_differs(high: float, doubted: bool) -> None:
    said = tables.doubts([{"plain_again": (0.98, high)}])
    assert bool(said) is doubted
    if doubted:
        assert "differs by up to 11%, more than 10%" in said[0]
