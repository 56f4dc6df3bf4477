"""Messages to users about the options of a draw-down."""

from grainfit.messages import Message

NO_ROOM_FOR_HEAP = Message(
    "a floor {distance:g} m below the shelf leaves no room for a heap whose apex is "
    "{clearance:g} diameters below it.",
    "Use at least {needed:g} m; 14 diameters are enough for most materials.",
)
FLOOR_IS_NARROW = Message(
    "a floor of half width {floor_half_width:g} m is not wider than the box of {width:g} m.",
    "Use at least {least:g} m.",
)
NONE_LEFT = Message("no particles are left")
ONE_SIDE = Message("all particles are on one side of the slot")
NO_SHEAR_ANGLE = Message("shear angle: {reason}")
SMOOTH_WALLS = Message(
    "with {key} = {value:g}, particles roll on its walls for long, so that runs may fail because "
    "the bed does not come to rest.",
    "Give {least:g} or more if your apparatus is not that smooth, or a longer settling_time_limit.",
)
