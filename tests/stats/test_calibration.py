"""Default tests keep their level, and their intervals cover, in a few simulated studies."""

import pytest

from bench.calibration import misses, run, table

FEW = 200
SLACK = 3.3
"""Monte-Carlo standard errors: of 70 shares at their limits, one in 30 runs would be beyond."""


@pytest.mark.slow
def test_a_short_calibration_keeps_its_limits():
    """Partial η² of heavy tails does not, and docs/statistics_checks.md says so."""
    kinds = [f"{generator} 12 {effect}" for generator in ("normal", "ssq") for effect in (0.0, 0.8)]
    kinds += ["heavy 12 0.0", "unequal 12 0.0"]
    counts: dict[str, dict[str, int]] = {}
    run(counts, FEW, lambda: None, kinds)
    assert {mine["studies"] for mine in counts.values()} == {FEW}
    assert misses(counts, SLACK, certain=True) == {}


def test_what_is_beyond_its_limit_is_found_and_printed_in_bold():
    counts = {
        "normal 8 0.0": {"studies": 2000, "t rejects": 130, "t covers": 1870, "t against p": 0},
        "normal 8 0.8": {"studies": 2000, "t rejects": 900, "t covers": 1800, "t against p": 1},
    }
    assert misses(counts) == {
        ("normal 8 0.0", "t rejects"): 0.065,
        ("normal 8 0.0", "t covers"): 0.935,
        ("normal 8 0.8", "t covers"): 0.9,
        ("normal 8 0.8", "t against p"): 0.0005,
    }
    assert ("normal 8 0.0", "t covers") not in misses(counts, certain=True)
    assert "| normal | 8 | 0.0 | **0.065 ± 0.006** | 0.935 ± 0.006 | 0.000 ± 0.000 |" in table(
        counts, ["normal"]
    )
