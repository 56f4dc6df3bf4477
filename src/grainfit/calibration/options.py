"""Options of a calibration that do not depend on its strategy."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import get_args

from grainfit.campaign.keep import Keep
from grainfit.options.fields import option, option_keys, read_options
from grainfit.options.kinds import Choice, Flag, Whole


@dataclass(frozen=True)
class CalibrationOptions:
    """Options of a calibration that do not depend on its strategy; None leaves the default.

    They are the fields below, as in the calibration file.

    Raises
    ------
    InputError
        Options with values that are not accepted; lists all of them.
    """

    max_runs: int | None = option(
        Whole(1),
        "Largest number of DEM runs, of all tests together, verification included. Runs of cheaper "
        "relatives (`softer`, `coarser`, `smaller`) count by what they cost: one of a tenth as a "
        "tenth. Without it, the search ends by itself.",
        default_text="none",
        example="60",
    )
    seed: int | None = option(
        Whole(0),
        "Determines the design and all insertion seeds: same seed, same calibration.",
        default_text="1",
        example="7",
    )
    workers: int | None = option(
        Whole(1, 4096),
        "Runs at a time.",
        default_text="as many as there are processor cores for",
        example="4",
    )
    verification_runs: int | None = option(
        Whole(2),
        "Fewest runs with fresh seeds at the answer.",
        default_text="3",
        example="8",
    )
    keep: Keep | None = option(
        Choice(get_args(Keep)),
        'Files of a finished run that are kept: all, or with "results" only its record, logs '
        "and pictures. Folders of failed runs are kept complete.",
        default_text='"all"',
        example='"results"',
    )

    near_runs: bool | None = option(
        Flag(),
        "Whether earlier runs of near problems guide the search: of the same bulk test, with fixed "
        "parameters and an apparatus that differ by at most a fifth. No verdict rests on them. "
        "Strategy: sequential.",
        default_text="true",
        example="false",
    )
    atlas: bool | None = option(
        Flag(),
        "Whether what the atlas expects guides the search. No verdict rests on it. "
        "Strategy: sequential.",
        default_text="true",
        example="false",
    )

    def __post_init__(self) -> None:
        read_options(option_keys(type(self)), asdict(self))
