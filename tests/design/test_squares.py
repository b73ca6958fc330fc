"""Squares, and random orders in blocks, checked by counting that knows nothing of how they came."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise, permutations

import numpy as np
import pytest

from vrcomfort.design import all_orders, latin_square, williams
from vrcomfort.design.orders import OrderConstraints, block_random
from vrcomfort.errors import InputError


def test_williams_balances_position_and_what_follows_what():
    for n in range(2, 13):
        square = np.array(williams(n))
        repeats = 1 if n % 2 == 0 else 2
        assert square.shape == (repeats * n, n)
        positions = np.zeros((n, n), dtype=int)
        follows = np.zeros((n, n), dtype=int)
        for row in square:
            positions[row, np.arange(n)] += 1
            np.add.at(follows, (row[:-1], row[1:]), 1)
        assert (positions == repeats).all()  # which also makes each row a whole order
        assert (follows[~np.eye(n, dtype=bool)] == repeats).all()
        assert (np.diag(follows) == 0).all()


def test_a_williams_square_has_the_same_orders_in_every_version():
    assert williams(4) == [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]


@pytest.mark.parametrize("n", [3, 5])
def test_an_odd_number_needs_two_squares(n):
    """By counting alone: no Latin square of n rows of a cyclic form balances carry-over."""
    rows = [first for first in permutations(range(n)) if first[0] == 0]
    for first in rows:
        square = [[(entry + row) % n for entry in first] for row in range(n)]
        pairs = Counter(pair for row in square for pair in pairwise(row))
        assert len(pairs) < n * (n - 1)


def test_a_latin_square_has_each_once_in_each_row_and_column():
    for n in range(1, 13):
        square = np.array(latin_square(n, np.random.default_rng(n)))
        for line in (*square, *square.T):
            assert sorted(line) == list(range(n))


def test_latin_squares_differ_by_their_random_numbers():
    squares = [latin_square(5, np.random.default_rng(seed)) for seed in range(20)]
    assert len({str(square) for square in squares}) == 20


def test_all_orders_are_all_of_them_once():
    assert len({tuple(order) for order in all_orders(5)}) == 120


SCENES = ["a", "a", "b", "b", "c", "c"]
BLUR = ["on", "off"] * 3
TRIAL = list("012345")


def drawn(seed, *, blocks=4, strata=None, **max_run):
    limits = OrderConstraints({"scene": SCENES, "blur": BLUR, "trial": TRIAL}, max_run, strata)
    return block_random(6, blocks, limits, np.random.default_rng(seed))


def longest_run(order, levels):
    longest = run = 1
    for before, after in pairwise(order):
        run = run + 1 if levels[before] == levels[after] else 1
        longest = max(longest, run)
    return longest


def test_every_block_has_everything_once():
    for seed in range(50):
        assert all(sorted(block) == list(range(6)) for block in drawn(seed))


def test_limits_hold_within_blocks_and_from_one_to_the_next():
    for seed in range(100):
        order = [item for block in drawn(seed, scene=1, blur=2, trial=1) for item in block]
        assert longest_run(order, SCENES) == 1
        assert longest_run(order, BLUR) <= 2


def test_without_limits_some_order_breaks_each_of_them():
    orders = [[item for block in drawn(seed) for item in block] for seed in range(100)]
    assert max(longest_run(order, SCENES) for order in orders) > 1
    assert max(longest_run(order, BLUR) for order in orders) > 2
    assert max(longest_run(order, TRIAL) for order in orders) > 1


def test_strata_are_spread_evenly():
    for seed in range(50):
        for block in drawn(seed, strata="scene"):
            scenes = [SCENES[item] for item in block]
            assert sorted(scenes[:3]) == sorted(scenes[3:]) == ["a", "b", "c"]


def test_all_orders_that_keep_the_limits_come():
    limits = OrderConstraints({"scene": ["a", "a", "b", "b", "c"]}, {"scene": 1}, None)
    possible = {
        order for order in permutations(range(5)) if longest_run(order, limits.levels["scene"]) == 1
    }
    met = {tuple(block_random(5, 1, limits, np.random.default_rng(seed))[0]) for seed in range(600)}
    assert met == possible


def test_the_same_seed_gives_the_same_order():
    assert drawn(3, scene=1) == drawn(3, scene=1)
    assert drawn(3, scene=1) != drawn(4, scene=1)


def test_limits_that_nothing_keeps_are_told():
    limits = OrderConstraints(
        {"scene": ["a", "a", "a", "b"], "x": list("0123")}, {"scene": 1}, None
    )
    with pytest.raises(InputError, match="no order of 4 trials was found"):
        block_random(4, 1, limits, np.random.default_rng(0))
