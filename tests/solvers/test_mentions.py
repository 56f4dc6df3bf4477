"""Parameters that a user's own model mentions, and names in its templates that are none."""

from __future__ import annotations

from pathlib import Path

import pytest

from grainfit.errors import InputError
from grainfit.options import messages
from grainfit.solvers.own_model.command import Command

NAMES = (
    "particle.density",
    "particle.youngs_modulus",
    "particle_particle.restitution",
    "particle_wall.restitution",
    "particle_wall.steel.restitution",
    "coh",
    "wall-angle",
)
VALUES = dict.fromkeys(NAMES, 1.0)


def written(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def mentioned(folder: Path, files: dict[str, str], *arguments: str, **options) -> set[str]:
    return set(Command(written(folder, files), ["true", *arguments], **options).depends_on(NAMES))


@pytest.mark.parametrize(
    ("deck", "names"),
    [
        ("variable r equal ${particle_wall_restitution}", {"particle_wall.restitution"}),
        ("variable r equal 2*v_particle_density", {"particle.density"}),
        ("fix f all print 1 '${coh}' # $(v_wall_angle)", {"coh", "wall-angle"}),
        ('values["particle_wall.steel.restitution"]', {"particle_wall.steel.restitution"}),
        ("density constant ${particle_densty} # density, cohesion, restitution", set()),
        ("${my_particle_density} ${particle_density_2} ${coh2} xv_coh", set()),
        ("json.load(open('parameters.json'))", set(NAMES)),
    ],
)
def test_a_deck_mentions_whole_names_alone(tmp_path, deck, names):
    assert mentioned(tmp_path, {"in.deck": deck}) == names


@pytest.mark.parametrize(
    ("template", "names"),
    [
        ("{{ particle.density * 2 }}", {"particle.density"}),
        ("{{ particle['density'] }}", {"particle.density"}),
        ("{% set p = particle %}{{ p.density }}", {"particle.density"}),
        ("{% set p = particle %}{{ p | attr('density') }}", {"particle.density"}),
        ("{% set s = particle_wall.steel %}{{ s.restitution }}", {NAMES[4]}),
        ("{% for p in [particle, wall] %}{{ p.density }}{% endfor %}", {"particle.density"}),
        ("{% macro m(p) %}{{ p.density }}{% endmacro %}{{ m(particle) }}", {"particle.density"}),
        ("{% for k in ['x'] %}{{ particle[k ~ k] }}{% endfor %}", set(NAMES[:2])),
        ('{{ parameters["wall-angle"] }}', {"wall-angle"}),
        ("{% for name, v in parameters.items() %}{{ v }}{% endfor %}", set(NAMES)),
        ("{% if false %}{{ coh }}{% endif %}", {"coh"}),
        ("${particle_density} {{ seed }}", {"particle.density"}),
        ("{# coh #}{{ seed }} density 'restitution' {{ 'coh' }}", set()),
    ],
)
def test_a_template_mentions_the_names_that_it_reads(tmp_path, template, names):
    assert mentioned(tmp_path, {"deck.j2": template}) == names
    assert mentioned(tmp_path, {"deck.j2": ""}, template) == names


def test_templates_that_others_include_count(tmp_path):
    files = {
        "deck.j2": "{% from 'lines.txt' import line %}{{ line(particle) }}",
        "lines.txt": "{% include 'more.txt' %}{% macro line(p) %}{{ p.density }}{% endmacro %}",
        "more.txt": "{% set c = particle_particle %}{{ c.restitution }}",
    }

    assert mentioned(tmp_path, files) == {"particle.density", "particle_particle.restitution"}


def test_words_of_the_evaluation_count_where_it_reads_values(tmp_path):
    evaluation = {"evaluate": "evaluate.py:measure"}
    code = "def measure(folder): coh = 1\n"

    assert mentioned(tmp_path, {"evaluate.py": code}, **evaluation) == set()
    assert mentioned(tmp_path, {"evaluate.py": code}, "evaluate.py", **evaluation) == {"coh"}
    code += "open('parameters.inc')"
    assert mentioned(tmp_path, {"evaluate.py": code}, **evaluation) == {"coh"}
    code += "open('parameters.json')"
    assert mentioned(tmp_path, {"evaluate.py": code}, **evaluation) == set(NAMES)


@pytest.mark.parametrize(
    ("template", "said"),
    [
        ("\n{{ cohh }}", 'deck.j2, line 2: cohh is no parameter that .* Did you mean "coh"'),
        ("{{ particle_particle.restituton }}", 'Did you mean "particle_particle.restitution"'),
        ("{{ particle_wall.brass.restitution }}", r"particle_wall\.brass\.restitution is no"),
        ("{{ partcle.density }}", r'partcle\.density is no .* Did you mean "particle.density"'),
        ('{{ parameters["wall angle"] }}', r'parameters\["wall angle"\] is no .* "wall-angle"'),
        ("{{ prime_sed }}", 'Did you mean "prime_seed"'),
        ("{% for i in range(nn) %}{% endfor %}", "nn is no parameter"),
        ("{% if cohh > 1 %}{% endif %}", "cohh is no parameter"),
    ],
)
def test_names_in_templates_that_are_no_parameters_are_refused_before_a_run(
    tmp_path, template, said
):
    folder = written(tmp_path, {"deck.j2": template, "use": " ".join(NAMES)})

    with pytest.raises(InputError, match=said):
        Command(folder, ["true"]).run_parameters(VALUES)


def test_a_misspelt_name_stands_for_the_parameter_that_is_meant(tmp_path):
    model = Command(written(tmp_path, {"deck.j2": "{{ particle.densty }}"}), ["true"])

    assert model.depends_on(NAMES) == ("particle.density",)
    with pytest.raises(InputError) as caught:
        model.run_parameters({"particle.density": 1.0})
    [fault] = caught.value.faults
    assert messages.MEANT.is_in(str(fault), name="particle.density")


def test_an_undefined_argument_is_refused_before_a_run(tmp_path):
    folder = written(tmp_path, {"use": " ".join(NAMES)})

    with pytest.raises(InputError, match=r"command\[1\], line 1: cohh is no parameter"):
        Command(folder, ["true", "{{ cohh }}"]).run_parameters(VALUES)


@pytest.mark.parametrize(
    "template",
    [
        "{{ seed }} {{ prime_seed }} {{ prime_seed_2 }} {{ coh.is_integer() }}",
        "{% set n = 3 %}{% for i in range(n) %}{{ i * loop.index }}{% endfor %}",
        "{% if more is defined %}{{ more.x }}{% endif %}{{ other | default(3) }}",
        "{% if coh > 2 %}{{ only_in_other_files }}{% endif %}{{ a.b if coh > 2 else 1 }}",
        "{% macro m(x, y=2) %}{{ x + y + only_in_other_files }}{% endmacro %}",
        "{% import 'lines' as l %}{% from 'lines' import a, b as c %}{{ l.x(a, c) }}",
        "{% set ns = namespace(k=1) %}{% set ns.k = 2 %}{{ ns.k }}{{ dict(a=1).a }}",
        "{% set text %}x{% endset %}{% with w = 1 %}{{ text }}{{ w }}{% endwith %}",
        "{% raw %}{{ nothing }}{% endraw %}{# {{ nothing }} #}{{ parameters.items() | list }}",
        "{% extends 'other' %}{% block b %}{{ set_by_other }}{{ super() }}{% endblock %}",
    ],
)
def test_names_that_a_template_has_or_may_not_need_are_accepted(tmp_path, template):
    folder = written(tmp_path, {"deck.j2": template, "use": " ".join(NAMES), "lines": ""})

    assert Command(folder, ["true"]).run_parameters(VALUES) == VALUES
