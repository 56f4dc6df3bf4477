"""The documentation site: `sphinx-build -W --keep-going docs build/site`."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))

project = "grainfit"
author = "The grainfit developers"
project_copyright = f"2026, {author}"
release = version = version_of("grainfit")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "gallery_figures",
    "moved_pages",
    "plain_attributes",
    "repository_pages",
]
exclude_patterns = ["_extensions", "_templates", "gallery", "notebooks", "recorded"]
templates_path = ["_templates"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}

# The pages are read on the web site of the repository too, which makes the same anchors.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False
# A name in single backticks is a link where there is such an object, and code elsewhere.
default_role = "py:obj"

html_theme = "furo"
html_title = f"grainfit {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_favicon = "_static/favicon.svg"
html_search_scorer = str(HERE / "_static" / "search.js")
copybutton_prompt_text = "$ "

sphinx_gallery_conf = {
    "examples_dirs": ["gallery", "notebooks"],
    "gallery_dirs": ["generated/gallery", "generated/notebooks"],
    "filename_pattern": "/plot_",
    "within_subsection_order": "ExampleTitleSortKey",
    "capture_repr": ("_repr_html_",),
    "image_scrapers": (),
    "reset_modules": (),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "write_computation_times": False,
}
