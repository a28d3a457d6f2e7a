"""The documentation site builds without a warning, its links lead somewhere, and it needs no network.

The environment names the program (RELIEF) and the folder to build in (RELIEF_DOCS_OUTPUT), whose pictures and pages are
kept from one run to the next. Exit status 77: the packages of docs/packages.txt are not installed.
"""
import html.parser
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
RELIEF = pathlib.Path(os.environ.get("RELIEF", ROOT / "build/release/relief"))
OUTPUT = pathlib.Path(os.environ.get("RELIEF_DOCS_OUTPUT", ROOT / "build/docs"))
HTML = OUTPUT / "html"

# What a browser fetches by itself, as opposed to where a reader may go.
FETCHED = {("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src"), ("source", "src"), ("object", "data")}


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.fetched, self.anchors = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name"):
                self.anchors.add(value)
            if (tag, name) in FETCHED:
                self.fetched.append(value)
            elif (tag, name) == ("a", "href"):
                self.links.append(value)


class Site(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        done = subprocess.run([ROOT / "tools/make_docs", RELIEF.parent, OUTPUT], capture_output=True, text=True)
        if done.returncode != 0:
            raise AssertionError(done.stderr[-4000:])
        cls.pages = {path: Page(path) for path in HTML.rglob("*.html")}

    def test_every_page_is_there(self):
        for path in [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs/howto").glob("*.md")]:
            self.assertIn(HTML / path.relative_to(ROOT / "docs").with_suffix(".html"), self.pages)
        for path in (ROOT / "include/relief").glob("*/*.h"):
            page = HTML / "api" / path.relative_to(ROOT / "include/relief").with_suffix(".html")
            self.assertIn(page, self.pages)

    def test_declarations_are_shown(self):
        """One of each kind: class, member, macro, enum, function, and names with all their namespaces."""
        for page, words in (("multires/ps_surface", ("_CPPv4N6relief8multires2ps7SurfaceE",)),
                            ("core/grid", ('id="_CPPv4N6relief10LatticeBoxE"', "row0")),
                            ("core/result", ("RELIEF_TRY", "ErrorCode")),
                            ("multires/box", ("relief::multires::box::analyse",)),
                            ("codec/raster_codec", ("encode_raster", "RasterFile", "decode_window"))):
            text = (HTML / f"api/{page}.html").read_text(encoding="utf-8")
            for word in words:
                self.assertTrue(word in text, (page, word))
            self.assertFalse("relief::relief" in text, page)

    def test_links_lead_somewhere(self):
        broken = []
        for path, page in self.pages.items():
            for link in page.links + page.fetched:
                parts = urllib.parse.urlsplit(link)
                if parts.scheme:
                    continue
                target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
                if not target.is_file():
                    broken.append(f"{path.relative_to(HTML)}: {link}")
                elif parts.fragment and target in self.pages and parts.fragment not in self.pages[target].anchors:
                    broken.append(f"{path.relative_to(HTML)}: {link}")
        self.assertEqual(broken, [])

    def test_nothing_is_fetched_from_a_network(self):
        for path, page in self.pages.items():
            for address in page.fetched:
                self.assertRegex(address, r"\A(?!/|\w+:)", path)
        for path in HTML.rglob("*.css"):
            style = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
            for address in re.findall(r"url\(\s*['\"]?([^'\")]*)|@import\s+['\"]([^'\"]*)", style):
                self.assertRegex("".join(address), r"\A(data:|#|(?!/|\w+:))", path)

    def test_gallery_has_pictures_with_their_commands(self):
        text = (HTML / "gallery.html").read_text(encoding="utf-8")
        pictures = [link for link in self.pages[HTML / "gallery.html"].fetched if link.startswith("_images/")]
        self.assertGreaterEqual(len(set(pictures)), 20)
        parts = re.split(r"<h3>", text)[1:]
        for part in parts:
            self.assertRegex(part, r"(?s)<img .*<pre>.*relief")
        self.assertEqual(len(parts), len(pictures))


def main():
    if not all(shutil.which(program, path="/usr/bin") for program in ("doxygen", "sphinx-build")):
        sys.exit(77)
    for module in ("breathe", "myst_parser", "furo"):
        if subprocess.run(["/usr/bin/python3", "-c", f"import {module}"], capture_output=True).returncode != 0:
            sys.exit(77)
    unittest.main()


if __name__ == "__main__":
    main()
