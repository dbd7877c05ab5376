"""The keys of the configuration, for type checkers."""

from __future__ import annotations

from typing import Literal, TypedDict


class PaperKeys(TypedDict, total=False):
    """The numbers of the method of Du 2022, used by `preset="paper"`."""

    median_px: Literal[1, 3, 5]
    window_px: tuple[int, int] | list[int]
    label_sd_px: float
    kernel_sigma: float
    learning_rate: float
    psr_threshold: float
    acceleration_variance_px2_s4: float
    colour_drive_variance_px2: float
    colour_coefficient: float
    white_variance_px2: float
    start_velocity_variance_px2_s2: float
    seed_variance_px2: float


class Keys(TypedDict, total=False):
    """The keys of `seamtrack config --print`; lengths in pixels unless the name says otherwise."""

    preset: Literal["robust", "paper"]
    joint: Literal["auto", "butt", "lap", "vgroove", "fillet"]
    stripe: Literal["auto", "horizontal", "vertical"]
    period_s: float
    mm_per_px: float | None
    seed_at: tuple[float, float] | list[float] | None
    roi: tuple[int, int, int, int] | list[int] | None
    fixed_lag: int | None
    speed_mm_s: float | None
    paper: PaperKeys
