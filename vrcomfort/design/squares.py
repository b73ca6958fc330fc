"""Orders that balance: squares of 0 … n−1, a row for each sequence."""

from __future__ import annotations

from itertools import permutations

import numpy as np


def latin_square(n: int, rng: np.random.Generator) -> list[list[int]]:
    """Return n orders of 0 … n−1 in which each stands once at each position.

    The cyclic square with its rows, columns and symbols in random order: what follows what is left
    to chance. `williams` balances that, too.
    """
    rows, columns, symbols = (rng.permutation(n) for _ in range(3))
    return [[int(symbols[(row + column) % n]) for column in columns] for row in rows]


def williams(n: int) -> list[list[int]]:
    """Return a Latin square of 0 … n−1 in which every ordered pair follows equally often.

    For even `n` the square has n rows; for odd `n` it takes 2n: the square and its mirror image.

    Notes
    -----
    Williams, E. J. (1949). Experimental designs balanced for the estimation of residual effects
    of treatments. Australian Journal of Scientific Research A 2, 149-168.
    """
    # The first row zigzags, 0, 1, n−1, 2, n−2, …: all differences of neighbours are distinct.
    zigzag = [(index + 1) // 2 if index % 2 else (n - index // 2) % n for index in range(n)]
    square = [[(entry + row) % n for entry in zigzag] for row in range(n)]
    return square if n % 2 == 0 or n == 1 else square + [row[::-1] for row in square]


def all_orders(n: int) -> list[list[int]]:
    """Return every order of 0 … n−1 once."""
    return [list(order) for order in permutations(range(n))]
