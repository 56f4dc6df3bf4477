"""Files of a finished run that are kept."""

from typing import Literal

#: All files of its folder, or only its record, logs and pictures.
Keep = Literal["all", "results"]
