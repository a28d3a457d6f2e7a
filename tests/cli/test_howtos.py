"""The how-tos and the quick start do what they say: their commands run, page by page, in an empty folder."""

import glob
import os
import re
import shutil
import subprocess
import tempfile
import unittest

from harness import RELIEF, ROOT, main


class HowTos(unittest.TestCase):
    def run_script(self, script, page):
        with tempfile.TemporaryDirectory(prefix="relief-howto-") as folder:
            path = os.path.dirname(os.path.abspath(RELIEF)) + os.pathsep + os.environ["PATH"]
            done = subprocess.run(["sh", "-e", "-u", "-c", script], cwd=folder, env={**os.environ, "PATH": path},
                                  capture_output=True, text=True, timeout=120, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), page)
            self.assertFalse(os.path.exists(os.path.join(folder, "failed.txt")), page)

    def test_commands_run(self):
        pages = sorted(glob.glob(os.path.join(ROOT, "docs/howto/*.md")))
        self.assertGreaterEqual(len(pages), 10)
        for page in pages:
            with open(page, encoding="utf-8") as file:
                script = "".join(re.findall(r"^```sh\n(.*?)^```$", file.read(), re.DOTALL | re.MULTILINE))
            if "gdal_" in script and not shutil.which("gdal_contour"):
                continue
            with self.subTest(page=os.path.basename(page)):
                self.assertIn("relief ", script)
                self.run_script(script, page)

    def test_quick_start_runs(self):
        with open(os.path.join(ROOT, "docs/quick-start.md"), encoding="utf-8") as file:
            lines = [line.strip() for line in file if line.startswith("    relief ")]
        self.assertGreater(len(lines), 10)
        self.run_script("\n".join(line for line in lines if not line.startswith("relief view")), "quick-start.md")


if __name__ == "__main__":
    main()
