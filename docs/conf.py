"""How the pages of this folder become a site: `make docs`.

Sphinx with MyST and furo: all three are kept up and free (BSD-2, MIT, MIT), and Sphinx reads numpydoc itself.
Material for MkDocs, the other candidate, is maintained until November 2026 only.
"""

from importlib.metadata import version as version_of

project = "softbed"
author = "the softbed developers"
project_copyright = f"2026, {author}"
release = version_of("softbed")
version = release

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
exclude_patterns = ["_build"]
highlight_language = "none"  # of blocks that name none
default_role = "code"  # a name in single backticks, as docstrings here have it

myst_heading_anchors = 3  # links such as analysis.md#the-lens, as code hosts make them
myst_enable_extensions = ["colon_fence"]

autodoc_mock_imports = ["torch"]  # optional, and large
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}
python_maximum_signature_line_length = 100
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = f"softbed {release}"
html_copy_source = False
html_show_sphinx = False
