from dataclasses import dataclass
from grainfit.bulk_tests.view import RunView
@dataclass(frozen=True)
class DischargeView(RunView):
    surfaces: object
def draw_discharge(*a): pass
