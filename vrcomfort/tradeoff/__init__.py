"""Trade-off of cost and error of blur methods, measured against two references.

To read in this order: `run` (all of it), `methods`, `cases` and `walk` (what is compared, and
where), `captures` and `references` (drawn by `brute_force`), `measure` with `error_measures` and
`image_error`, `costs`, `results`, then `tables`, `figures` and `files`. `store` keeps finished
work; `focus_search` is a measurement of its own.
"""
