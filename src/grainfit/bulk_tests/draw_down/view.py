"""Pictures of a draw-down."""
from dataclasses import dataclass
from grainfit.bulk_tests.view import RunView
@dataclass(frozen=True)
class DrawDownView(RunView):
    surfaces: object
def draw_draw_down(path, surfaces, result): pass
