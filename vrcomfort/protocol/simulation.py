"""The behaviour of simulated participants: the [simulation] table of a protocol."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from vrcomfort.settings import Settings

Probability = Annotated[float, Field(ge=0, le=1)]
Coefficient = Annotated[float, Field(ge=0, le=1e6)]
PositiveCoefficient = Annotated[float, Field(ge=1e-6, le=1e6)]


class SimulatedEyes(Settings):
    """Eyes of simulated participants, where a headset or trace has none.

    Fixations of log-normal length at places spread about the head's forward direction, saccades on
    the main sequence (Bahill et al. 1975), blinks, and the error of a tracker: an offset for each
    person, another for each of their eyes, and noise.
    """

    fixation_s: Annotated[float, Field(ge=0.05, le=60)] = 0.3
    """Median length of a fixation."""
    spread_deg: tuple[
        Annotated[float, Field(ge=0, le=45)], Annotated[float, Field(ge=0, le=45)]
    ] = (10.0, 7.0)
    """Standard deviation of where they look, to the side and up."""
    blink_every_s: Annotated[float, Field(ge=0.5, le=3600)] = 4.0
    """Mean time between two blinks."""
    blink_s: Annotated[float, Field(ge=0.01, le=1)] = 0.15
    """How long a blink lasts, in which the tracker sees nothing."""
    error_deg: Annotated[float, Field(ge=0, le=30)] = 0.5
    """Standard deviation, over people and along each axis, of the tracker's offset."""
    eye_error_deg: Annotated[float, Field(ge=0, le=30)] = 0.3
    """The same for the error of each eye's own line of sight, besides."""
    noise_deg: Annotated[float, Field(ge=0, le=10)] = 0.1
    """Standard deviation of a sample around it, along each axis."""
    pupil_mm: Annotated[float, Field(ge=1, le=10)] = 4.0
    """Diameter of the pupils that the tracker tells."""


class Simulation(Settings):
    """Coefficients of the simulated participants (`vrcomfort.respondent.simulated`).

    Sickness grows by `rate_per_min` × susceptibility × condition × scene × habituation^(session−1)
    and decays with time constant `recovery_min`.
    """

    susceptibility_sigma: Coefficient = 0.7
    """Standard deviation of the logarithm of susceptibility (median 1)."""
    rate_per_min: Coefficient = 0.06
    """How fast sickness grows."""
    recovery_min: PositiveCoefficient = 20.0
    """Time in which sickness decays to 1/e."""
    habituation: PositiveCoefficient = 0.85
    """Factor of growth from one session to the next."""
    condition_effects: dict[str, Coefficient] = Field(default_factory=dict)
    """Condition → factor of growth in it; 1 without it."""
    scene_effects: dict[str, Coefficient] = Field(default_factory=dict)
    """Scene → the same."""
    baseline_sd: Coefficient = 0.45
    """Spread of stable item levels: most people do not start at zero."""
    noise_sd: Coefficient = 0.3
    """Spread of one answer around its latent value."""
    hazard_per_min: Coefficient = 0.05
    """Withdrawal rate per minute and unit of sickness above `tolerance`."""
    tolerance: Coefficient = 0.8
    """Sickness below which there are no withdrawals."""
    refusal: Probability = 0.5
    """Chance that a withdrawn participant refuses the questionnaire that follows."""
    question_hazard: Probability = 0.0005
    """Chance of withdrawing at any one question, per unit of sickness."""
    missed_rating: Probability = 0.05
    """Chance that a rating is missed."""
    reaction_s: Annotated[float, Field(ge=0.05, le=60)] = 0.7
    """Median reaction time to a task's target; half of it after a miss."""
    reaction_sigma: Annotated[float, Field(ge=0, le=2)] = 0.25
    """Standard deviation of the logarithm of that time."""
    aim_sd_deg: Annotated[float, Field(ge=0, le=45)] = 0.6
    """Spread of where they point, along each axis."""
    aim_lag_s: Annotated[float, Field(ge=0, le=10)] = 0.1
    """For how long they aim at where a moving target was."""
    task_sigma: Annotated[float, Field(ge=0, le=2)] = 0.0
    """How much people differ in these three: standard deviation of the logarithm of a factor."""
    skill_effects: dict[str, dict[str, PositiveCoefficient]] = Field(default_factory=dict)
    """Covariate → level → factor of the three; 1 without it."""
    break_extra_s: Annotated[float, Field(ge=0, le=86_400)] = 20.0
    """For how long, on average, they stay in a break that they may end."""
    eyes: SimulatedEyes | None = None
    """Where they look, if neither headset nor trace has gaze; without it, nothing tells."""
    liking: dict[str, Annotated[float, Field(ge=-100, le=100)]] = Field(default_factory=dict)
    """Condition → how much they like it, in standard deviations of a judgement; 0 without it."""
    indifference: Coefficient = 0.5
    """Two that seem to differ by less are alike to them: no preference, where that may be said."""
    answers: dict[str, Probability] = Field(default_factory=dict)
    """Item → place of the mean answer in its range, 0 to 1; without it, sickness decides."""
    task_effects: dict[str, PositiveCoefficient] = Field(default_factory=dict)
    """Condition → factor of reaction times and spread in it; 1 without it."""
    task_effect_sigma: Annotated[float, Field(ge=0, le=2)] = 0.0
    """How much people differ in how a condition affects them there: standard deviation of the
    logarithm of a factor of each person in each condition."""
    screened_out: Probability = 0.5
    """Chance that the experimenter stops where a screening rule is broken."""
    adjusts_to: dict[str, Annotated[float, Field(ge=-1e9, le=1e9)]] = Field(default_factory=dict)
    """Adjustment → the value that they adjust to in the median; without it, the middle of its
    range."""
    adjust_sd: Annotated[float, Field(ge=0, le=1)] = 0.1
    """How much people differ in it: standard deviation in parts of the range, on its scale."""
    adjust_noise: Annotated[float, Field(ge=0, le=1)] = 0.03
    """How much the adjustments of one person do."""
