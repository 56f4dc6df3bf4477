"""Files that stay of a finished run."""

from typing import Literal

#: All files of its folder, or its record, logs and pictures.
Keep = Literal["all", "results"]
