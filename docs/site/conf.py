"""The documentation site. tools/make_docs assembles its pages and says where the build is, in RELIEF_DOCS."""
import os
import pathlib

_build = pathlib.Path(os.environ["RELIEF_DOCS"])

project = "relief"
author = "the authors of relief"
version = release = os.environ["RELIEF_VERSION"]
extensions = ["myst_parser", "breathe"]
root_doc = "index"

# Nothing is fetched from a network: no fonts, no scripts, and formulas are plain text.
html_theme = "furo"
html_title = "relief"
html_static_path = ["static"]
html_css_files = ["relief.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#2f6b3c", "color-brand-content": "#2f6b3c"},
    "dark_css_variables": {"color-brand-primary": "#9ccf9a", "color-brand-content": "#9ccf9a"},
}
pygments_style = "tango"
pygments_dark_style = "monokai"
highlight_language = "none"

myst_heading_anchors = 4

breathe_projects = {"relief": str(_build / "xml")}
breathe_default_project = "relief"
breathe_show_include = False
primary_domain = "cpp"
