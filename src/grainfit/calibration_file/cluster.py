"""The ``[cluster]`` table of the calibration file, derived from the declared options."""

from __future__ import annotations

from grainfit.campaign.cluster import ClusterOptions
from grainfit.errors import InputError
from grainfit.options.fields import option_keys
from grainfit.options.places import Place
from grainfit.options.tables import Values

CLUSTER = option_keys(ClusterOptions)


def cluster_options(values: Values, place: Place) -> ClusterOptions | None:
    """Build the options from the values read; None after noting their faults."""
    if None in values.values():
        return None
    try:
        return ClusterOptions(**values)
    except InputError as error:
        for fault in error.faults:
            place.at(fault.key).refuse(fault)
    return None
