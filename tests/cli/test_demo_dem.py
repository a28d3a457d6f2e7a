"""The demonstration's elevation model: every goal, as the demonstration uses it."""

import os
import subprocess
import sys

import numpy as np

from harness import ROOT, Case, energy, finite, main, read_raster, samples

ARCHIVE = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"


class DemoDem(Case):
    def setUp(self):
        super().setUp()
        if not os.path.exists(ARCHIVE):
            self.skipTest(f"there is no {ARCHIVE}: apt-get install python-matplotlib-data")
        self.dem = self.path("dem.tif")
        subprocess.run([sys.executable, os.path.join(ROOT, "tools/demo_dem.py"), self.dem],
                       check=True)
        self.values = samples(self.dem)

    def test_max_error(self):
        for bound in (1, 5, 25):
            file, report = self.encoded(self.dem, "--max-error", bound)
            surface, _ = self.decoded(file)
            self.assertLessEqual(np.max(np.abs(surface - self.values)), bound)
            # Half an hour of arc of ridges: a bit of the 16 is far more than a metre needs.
            self.assertLess(report["bits_per_sample"], {1: 4.2, 5: 2.1, 25: 0.6}[bound])

    def test_rms_error_and_bytes(self):
        for goal in (2, 10):
            file, report = self.encoded(self.dem, "--rms-error", goal)
            surface, _ = self.decoded(file)
            rms = np.sqrt(np.mean(np.square(surface - self.values)))
            self.assertLessEqual(rms, goal)
            self.assertGreaterEqual(rms, 0.9 * goal)
        for goal in (5000, 30000):
            file, report = self.encoded(self.dem, "--bytes", goal)
            self.assertTrue(0.95 * goal <= os.path.getsize(file) <= goal)
            self.assertTrue(finite(report["energy_percent"]))

    def test_lossless(self):
        file, report = self.encoded(self.dem)
        self.assertTrue(np.array_equal(self.decoded(file)[0], self.values))
        # DEFLATE with a predictor takes 138 kB of it.
        self.assertLess(report["bytes"], 100000)
        self.assertEqual(read_raster(self.path("out.tif")).unit, "m")

    def test_papers_rates_quartic_below_linear(self):
        for percent in (36, 24.5, 13, 6.2):
            energies = []
            for order in (1, 2):
                file, report = self.encoded(self.dem, "--keep", percent, "--levels", 3,
                                            "--scheme", "barycentric", "--order", order)
                surface, _ = self.decoded(file)
                self.assertEqual(report["kept"], round(percent / 100 * self.values.size))
                energies.append(energy(surface - self.values))
            self.assertLess(energies[1], energies[0], percent)


if __name__ == "__main__":
    main()
