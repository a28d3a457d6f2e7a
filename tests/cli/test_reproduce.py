"""relief-reproduce: what the source papers print and can be known exactly comes out as printed."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = pathlib.Path(os.environ["RELIEF"]).parent / "relief-reproduce"


class Reverse(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        done = subprocess.run([PROGRAM, "--json"], capture_output=True, text=True, timeout=120, check=True,
                              env={**os.environ, "RELIEF_DATA": "/nonexistent"})
        cls.rows = [row for row in json.loads(done.stdout) if row["source"].startswith("reverse subdivision")]

    def rows_of(self, *cases):
        rows = [row for row in self.rows if row["case"].startswith(cases)]
        self.assertTrue(rows)
        return rows

    def ours(self, case, quantity):
        (row,) = (row for row in self.rows if (row["case"], row["quantity"]) == (case, quantity))
        return row["ours"]

    def test_fractions_are_derived_exactly(self):
        rows = self.rows_of("figure 20", "appendix (A", "section 9")
        self.assertEqual(len(rows), 5 + 5 + 12 + 2 + 4)
        for row in rows:
            self.assertTrue(row["note"].startswith("exactly "), row)
        notes = [row["note"] for row in self.rows_of("appendix (A.1)")]
        self.assertEqual(notes[0], "exactly -360908824401952/6124761750733245")
        self.assertEqual(self.rows_of("appendix A")[0]["ours"], 0)

    def test_formulas(self):
        for row in self.rows_of("(5.", "(10.1)", "section 8"):
            self.assertAlmostEqual(row["ours"], row["paper"], delta=1e-13 * abs(row["paper"]))

    def test_experiments(self):
        for steps, item in ((1, "figure 26, torus"), (2, "figure 28, irregular")):
            self.assertLess(self.ours(item, f"{steps} steps down: off the polyhedron, max"), 1e-13)
        for levels in (1, 2, 4):
            (row,) = (row for row in self.rows_of("figure 31")
                      if row["quantity"] == f"none, level {levels}: move of the vertex")
            self.assertAlmostEqual(row["ours"], row["paper"], delta=1e-12)
        # Lifting brings near what plain reversal does not, and keeps noise down.
        for scheme in ("sqrt3, 4", "loop, 3", "catmull-clark, 3"):
            item = f"{scheme} steps"
            self.assertLess(self.ours(item, "chebyshev: residual / least, noisy shape"), 1.006)
            self.assertGreater(self.ours(item, "none: residual / least, noisy shape"), 1.5)
            self.assertLess(self.ours(item, "chebyshev: noise at the base"), 0.6)
            self.assertGreater(self.ours(item, "none: noise at the base"), 40)

    def test_figures(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, "--figures", folder], timeout=120, check=True)
            names = sorted(os.listdir(folder))
            self.assertEqual(names, ["figure23.svg", "figure25.png", "figure26.png", "figure28.png", "figure30.png",
                                     "figure31.png", "figure33.png", "smooth.png"])
            svg = pathlib.Path(folder, "figure23.svg").read_text(encoding="ascii")
            self.assertEqual((svg.count("<path"), svg.count("<text")), (9, 3))


if __name__ == "__main__":
    if not PROGRAM.exists():
        sys.exit(77)
    unittest.main()
