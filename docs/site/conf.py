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
html_theme_options = {  # a green that can be read on white and on black
    f"{theme}_css_variables": {"color-brand-primary": "#3b8a50", "color-brand-content": "#3b8a50"}
    for theme in ("light", "dark")
}
pygments_style = "tango"
pygments_dark_style = "monokai"
highlight_language = "none"

myst_heading_anchors = 4

breathe_projects = {"relief": str(_build / "xml")}
breathe_default_project = "relief"
breathe_show_include = False
primary_domain = "cpp"
