"""Statistics of comfort studies: tables and arrays in, dataclasses out.

Each module can be used without the rest of the package: `signed_rank` (exact with ties), `shift`
(Hodges-Lehmann), `effects` (effect sizes with intervals), `multiplicity` (Holm), `anova` (within,
between and mixed), `mixed` (all available data; the crossover), `rank_anova` (Friedman,
Kruskal-Wallis, aligned ranks), `ordinal`, `survival`, `rating_courses`, `gaze_and_head`.
"""
