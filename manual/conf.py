"""How the manual is built: `sphinx-build -W --keep-going -n manual OUT`. Nothing is fetched, at build or when it is read."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from imo_analysis import __version__

project = "imo_analysis"
author = "the authors of imo_analysis"
release = version = __version__
extensions = ["myst_parser", "imo_manual"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["README.md", "imo_manual"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
default_role = "pyname"
nitpicky = True
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"imo_analysis {version}"
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_show_sphinx = False
html_copy_source = False
html_show_copyright = False
html_baseurl = ""
python_maximum_signature_line_length = 90
toc_object_entries = False
add_module_names = False
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
html_theme_options = {"footer_icons": [], "light_css_variables": {"font-stack": "system-ui, 'Segoe UI', Roboto, sans-serif"}}
