"""Messages of measurements on photographs: why a picture is refused, and what to do."""

from grainfit.messages import Message

NO_FILE = Message("{path}: there is no such file.")
UNREADABLE = Message(
    "{path}: is not a picture that can be read ({reason}).",
    "Pictures are JPEG, HEIC, PNG, BMP or TIFF.",
)
SAME_PICTURE = Message(
    "has {file}, which is the same file as {other}.", "It counts once: leave one of them out."
)

# Separation of the heap.
NO_HEAP = Message(
    "no heap is found: no part of the picture that has a colour or a brightness of its own looks "
    "like a cone (the best one agrees to {share:.0f} %, and {needed:.0f} % are needed).",
    "Put a plain background of another brightness behind the heap and on the table, keep other "
    "things out of the picture, and avoid shadows and mirrored light.",
)
NO_FOCAL_LENGTH = Message(
    "the picture does not say the focal length of its lens (EXIF), and it cannot be measured with "
    "every usual one: {why}",
    "Take the file of the camera: messengers and editors remove what it says of the lens.",
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

COARSE = Message(
    "the heap is {height:.0f} pixels high, and its particles are {diameter:.0f} pixels large, as "
    "given or by the roughness of its outline: it has no flanks.",
    "Photograph a heap of more particles.",
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
    "(elevation).",
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
    "is of use with a known length only.", "Give the diameter of the plate, too (plate)."
)
ALL_REFUSED = Message("none of the pictures can be measured:\n{reasons}")
REFUSED = Message("{path}: {reason}")
ONE_HEAP = Message(
    "This is one heap: fill three or four from the same sample for how heaps differ."
)
OTHER_TEST = Message(
    "is {test!r}.", "These are photographed: heap, funnel, draw_down, drum, slope."
)
IMPOSSIBLE = Message("is {given!r}, and must be above zero.")

# Drums.
NO_DRUM = Message(
    "no drum is found: no whole circle stands out on most of its circumference.",
    "Photograph the drum along its axis, wholly, with a rim that differs from what is in it.",
)
DRUM_CUT_OFF = Message(
    "the drum is cut off by the edge of the picture.", "Photograph the whole drum."
)
SMALL_DRUM = Message(
    "the drum is {width:.0f} pixels wide, and {needed:.0f} are needed.", "Go nearer, or zoom in."
)
OBLIQUE = Message(
    "the drum is seen {angle:.0f} degrees beside its axis, and {most:g} are allowed.",
    "Put the camera before the middle of the drum.",
)
NO_SURFACE = Message(
    "no free surface is found in the drum: nothing in it differs from the rest along a line.",
    "Put something plain and of another brightness behind the drum, and avoid reflections.",
)
SURFACE_WITHOUT_CONTRAST = Message(
    "the bed does not stand out from the empty drum: the logarithms of the frequencies of their "
    "colours are {found:.1f} apart at the surface, and {needed:g} are needed.",
    "Put something plain and of another brightness behind the drum, and avoid reflections.",
)
UNSURE_SURFACE = Message(
    "the surface is not sure: the bed is inclined by {low:.1f} or {high:.1f} degrees, depending on "
    "which colours are taken as those of the bed.",
    "Use an even light, avoid reflections, and put something plain behind the drum.",
)
DIRTY_DRUM = Message(
    "{share:.0f} % of what is above the surface looks like the bed, and {most:g} % are allowed: "
    "particles stick to the glass or are thrown, or the drum is lit badly.",
    "Clean the glass, earth the drum, or turn it more slowly.",
)
BED_LIKE_DRUM = Message(
    "{share:.0f} % of the bed has the colours of the empty drum, and {most:g} % are allowed.",
    "Put something plain and of another brightness behind the drum.",
)
UNEVEN_SURFACE = Message(
    "the surface jumps or bulges by {share:.0f} % of the radius, and {most:.0f} % are allowed: "
    "something that is no part of the bed has its colours, such as a reflection.",
    "Avoid reflections, and put something plain and of another brightness behind the drum.",
)
CAMERA_MOVES = Message(
    "the camera moves: from the first to the last frame the drum is elsewhere.",
    "Put the camera on a stand.",
)
NO_VIDEO = Message(
    "{path}: is not a video that can be read.", "MP4, MOV, AVI, MKV and WebM can be read."
)
FEW_FRAMES = Message(
    "there are {found} frames, and {needed} are needed.", "Film some avalanches, or several turns."
)
FEW_STILLS = Message(
    "there are {found} pictures of the drum turning one way that can be measured, and {needed} are "
    "needed for a mean.",
    "Take more, some seconds apart, or a video.",
)
SHORT_VIDEO = Message(
    "in {seconds:.1f} s there are too few whole avalanches for a standard error.",
    "Film more turns of the drum.",
)
STILL_DRUM = Message("nothing moves in the drum.", "Film it while it turns.")
UNSTEADY = Message(
    "the bed is not steady: its inclination changes by {change:.1f} degrees from the first to the "
    "second half.",
    "Let the drum turn some times before you film.",
)
TURNS_OVER = Message(
    "the bed is inclined by {angle:.0f} degrees: this is no bed that flows down its surface."
)
NO_MARK = Message(
    "No mark is seen on the rim, so the rotational speed is not known: count it, or put a piece of "
    "tape on the rim.",
)
LEVEL = Message(
    "It is taken that the camera is level within {error:g} degrees (level). The marker sheet, or "
    "a second video of the drum that turns the other way, would tell it."
)
PERSPECTIVE = Message(
    "Perspective makes the dynamic angle too small by up to a degree: give the distance of the "
    "camera before the drum, with the drum's diameter and length (distance, drum, length)."
)
WHOLE_DRUM = Message(
    "is of use with the others only.",
    "Give the distance of the camera, the diameter and the length of the drum, or none of them.",
)
DRUM_ONLY = Message("is of use for a drum only.", "Choose the test drum, or leave it out.")
NOT_OF_DRUM = Message("is of no use for a drum.", "Leave it out.")

# Draw-downs.
NO_WEDGES = Message(
    "the wedges on the shelf are not seen: material of the heap's colour is left in {left} parts "
    "above it to the left, and in {right} to the right.",
    "Show the whole box, with a plain background behind the slot and behind both wedges.",
)
NO_SHEAR_ANGLE = Message(
    "the wedges have no angle: {reason}",
    "If the particles are smaller, give their diameter and the width of the box (diameter, box).",
)
WEDGES_CUT_OFF = Message(
    "a wedge is cut off by the edge of the picture.", "Photograph the whole box."
)
UNEQUAL_FLANKS = Message(
    "its two flanks are inclined by {low:.1f} and {high:.1f} degrees, and may be {most:g} apart: a "
    "reflection hides one, particles stick to the glass, or the slot did not open evenly.",
    "Clean the glass, avoid reflections, and look at the overlay.",
)
BOX_AND_DIAMETER = Message(
    "is of use with the other only.",
    "Give the inner width of the box and the diameter of the particles, or neither.",
)
BOX_ONLY = Message("is of use for a draw-down only.", "Choose the test draw_down, or leave it out.")
NOT_OF_DRAW_DOWN = Message("is of no use for a draw-down.", "Leave it out.")

# Slopes.
NO_SLOPE = Message(
    "no slope is found: no straight edge that is neither level nor upright is longer than "
    "{share:.0f} % of the picture.",
    "Photograph plane or bed from the side, large in the picture, before a plain background of "
    "another brightness.",
)
TWO_SLOPES = Message(
    "there are two slopes of nearly the same length, of {first:.1f} and {second:.1f} degrees.",
    "Keep other inclined edges out of the picture.",
)
FAINT_SLOPE = Message(
    "the edge of the slope is seen on {share:.0f} % of its length only.",
    "Put a plain background of another brightness behind it.",
)
BENT_SLOPE = Message(
    "its two halves are inclined by {bend:.1f} degrees to each other, and at most {most:g} are "
    "those of one slope.",
    "Photograph a plane, or a bed that is not curved.",
)
SHORT_REFERENCE = Message(
    "the points of the reference are too near to each other.",
    "Give two points far apart on a level edge (reference).",
)
LEVEL_SLOPE = Message(
    "It is taken that the camera is level within {error:g} degrees (level). The marker sheet, or "
    "two points of a level line in the picture (reference), would tell it."
)
ONE_SLOPE = Message("This is one picture: tilt the plane three or four times anew.")
SLOPE_ONLY = Message("is of use for a slope only.", "Choose the test slope, or leave it out.")
NOT_OF_SLOPE = Message("is of no use for a slope.", "Leave it out.")
NO_REFERENCE = Message("is {given!r}.", 'Give two points in pixels: "100,912 1480,915".')

# By hand.
BY_HAND = Message("{drawn} drawn by hand")
NO_PLACES = Message("places on a picture are pairs of numbers.")
OTHER_COUNT = Message("{name} has {count} points, or is no part that can be drawn.")
DAMAGED = Message(
    "{path}: cannot be read ({reason}).",
    "Remove it, and draw again: 'grainfit photo --edit PICTURE'.",
)
OTHER_PICTURE = Message(
    "{path}: was drawn on another picture than {picture}.",
    "Remove it, and draw again: 'grainfit photo --edit PICTURE'.",
)
NO_RECTANGLE = Message(
    "the four points are no corners of a rectangle.",
    "Give the four corners of a level rectangle that is seen wholly.",
)
NOT_LEVEL = Message(
    "the four points are not those of a rectangle by this camera: its sides would not be at right "
    "angles.",
    "Give the corners of a level rectangle in a picture with EXIF data that is not cropped.",
)
OTHER_SHAPE = Message(
    "the four points are those of a rectangle with sides in the ratio {ratio:.2f}, not of the one "
    "that is given.",
    "Look at the points and at the sides (rectangle).",
)
ONE_PICTURE = Message(
    "is for one picture.",
    "Measure the pictures one by one, or draw on each: 'grainfit photo --edit PICTURE'.",
)
NO_POINTS = Message(
    "is {given!r}.", 'Give four points in pixels: "412,880 1190,871 1402,1015 250,1030".'
)
NO_SIDES = Message("is {given!r}.", 'Give two lengths: "297 mm x 210 mm".')
