"""Messages of measurements on photographs: why a picture is refused, and what to do."""

from grainfit.messages import Message

NO_FILE = Message("{path}: there is no such file.")
UNREADABLE = Message(
    "{path}: is not a picture that can be read ({reason}).",
    "Pictures are JPEG, HEIC, PNG, BMP or TIFF.",
)

# Separation of the heap.
NO_HEAP = Message(
    "no heap is found: no part of the picture that has a colour or a brightness of its own looks "
    "like a cone (the best one agrees to {share:.0f} %, and {needed:.0f} % are needed).",
    "Put a plain background of another brightness behind the heap and on the table, keep other "
    "things out of the picture, and avoid shadows and mirrored light.",
)
CUT_OFF = Message(
    "the heap is cut off by the edge of the picture.",
    "Photograph the whole heap, with some background on all sides.",
)
TWO_HEAPS = Message(
    "there are two things that look like heaps, the second has {share:.0f} % of the area of the "
    "first.",
    "Photograph one heap at a time.",
)
NO_CONTRAST = Message(
    "the heap does not stand out: it differs from what is beside its {side} flank by {ratio:.1f} "
    "times the scatter there, and {needed:.0f} times are needed.",
    "Put a background of another brightness behind it.",
)
UNSURE_OUTLINE = Message(
    "the outline is not sure: the angle is {low:.1f} or {high:.1f} degrees, depending on where the "
    "heap is taken to end.",
    "Use an even light and a background of another brightness.",
)
SMALL = Message(
    "the heap is {width:.0f} pixels wide, and {needed:.0f} are needed.",
    "Go nearer, or zoom in.",
)

WIDE_FOOT = Message(
    "what was found is {factor:.1f} times as wide as its flanks, and at most {most:g} times are "
    "those of a heap: a plate, a shadow or scattered particles belong to it.",
    "Look at the overlay, and give heap and plate different brightnesses.",
)

# The camera.
TOO_HIGH = Message(
    "it is seen from {elevation:.1f} degrees above; a heap of {angle:.1f} degrees shows its flanks "
    "up to {limit:.1f} degrees.",
    "Lower the camera: to the height of the plate is best.",
)
FROM_ABOVE = Message(
    "it is seen from too high: in the picture the heap is hardly higher than its foot is deep.",
    "Lower the camera: to the height of the plate is best.",
)
UNSURE_ELEVATION = Message(
    "the elevation of the camera, {elevation:.1f} ± {error:.1f} degrees above the plate, is too "
    "uncertain: the angle would be uncertain by {angle_error:.1f} degrees.",
    "Lower the camera, put the heap on a round plate that is seen wholly, or give the elevation "
    "(--elevation).",
)
ELEVATIONS_DISAGREE = Message(
    "the camera is {foot:.1f} degrees above the plate by what the picture shows, and "
    "{elevation:.1f} degrees by {other}.",
    "Photograph the whole foot of a round heap, and give the elevation of the camera only where it "
    "is known.",
)

NO_PLATE = Message(
    "the edge of the plate is not seen.",
    "Show the whole plate, of another brightness than the table, or leave out its diameter: an "
    "angle does not need it.",
)

NO_MARKER = Message(
    "two or more markers of the sheet are not seen.",
    "Show the sheet whole and in focus, or leave out marker = true.",
)

NO_SCALE = Message(
    "its lengths are not known, and an outline has lengths.",
    "Show the marker sheet, or give the diameter of the plate.",
)
SHORT_OUTLINE = Message(
    "the outline has room for {count} points two particle diameters apart, and {needed} are "
    "needed.",
    "Use a larger heap.",
)

# All pictures.
NO_PICTURES = Message(
    "there is no picture in {folder}.", "Pictures are JPEG, HEIC, PNG, BMP, TIFF."
)
NONE_GIVEN = Message("there is no picture.", "Give one or more pictures, or folders of pictures.")
NO_LENGTH = Message(
    "is of use with a known length only.", "Give the diameter of the plate, too (--plate)."
)
ALL_REFUSED = Message("none of the pictures can be measured:\n{reasons}")
REFUSED = Message("{path}: {reason}")
ONE_HEAP = Message(
    "This is one heap: fill three or four from the same sample for how heaps differ."
)
OTHER_TEST = Message("is {test!r}.", "Heaps of these tests are measured: heap, funnel.")
IMPOSSIBLE = Message("is {given!r}, and must be above zero.")
