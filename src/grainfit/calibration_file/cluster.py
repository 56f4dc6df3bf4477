"""The ``[cluster]`` table of the calibration file, derived from the declared options."""

from __future__ import annotations

from grainfit.campaign.cluster import ClusterOptions
from grainfit.errors import InputError
from grainfit.options.fields import option_keys
from grainfit.options.places import Place
from grainfit.options.tables import Values

CLUSTER = option_keys(ClusterOptions)


def cluster_options(values: Values, place: Place) -> ClusterOptions | None:
    """Build the options from the values read; None after noting their faults.

    Faults of the values read are noted already, beside which there may be others.
    """
    known = {key: value for key, value in values.items() if value is not None}
    bad = values.keys() - known.keys()
    # They decide what the other keys mean.
    if bad & {"scheduler", "parsl"}:
        return None
    try:
        options = ClusterOptions(**known)
    except InputError as error:
        for fault in error.faults:
            if fault.key not in bad:
                place.at(fault.key).refuse(fault)
        return None
    return None if bad else options
