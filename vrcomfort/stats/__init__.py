"""Statistics of comfort studies: tables and arrays in, dataclasses and tables out.

Each module is one idea and can be used without the rest of the package:
`signed_rank` (exact with ties), `shift` (Hodges-Lehmann), `effects` (effect sizes with
intervals), `multiplicity` (Holm), `anova` (within, between and mixed, with `sphericity`),
`crossover` (two periods), `mixed` (all available data), `friedman`, `withdrawal`.
"""
