"""What the tests of the GDAL driver share, over that of the command line's tests.

The environment names the folder of the driver (GDAL_DRIVER_PATH) and the program (RELIEF).
"""

import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
os.environ.setdefault("GDAL_DRIVER_PATH", os.path.join(ROOT, "build/release/plugins/gdal"))
sys.path.insert(0, os.path.join(ROOT, "tests/cli"))

from osgeo import gdal  # noqa: E402

import harness  # noqa: E402

gdal.AllRegister()  # again, as the folder may not have been known before


def band(path, *open_options, number=1):
    """A band; its dataset lives as long as it does."""
    dataset = gdal.OpenEx(path, gdal.OF_RASTER, open_options=list(open_options))
    result = dataset.GetRasterBand(number)
    result.owner = dataset
    return result


def values(path, *open_options):
    return band(path, *open_options).ReadAsArray()


class DriverCase(harness.Case):
    def setUp(self):
        super().setUp()
        self.addCleanup(self.no_side_files)

    def no_side_files(self):
        if os.path.isdir(self.directory):
            self.assertEqual([n for n in os.listdir(self.directory) if n.endswith(".xml")],
                             self.side_files)

    side_files = []

    def tool(self, *arguments):
        """Standard output of a tool that must succeed."""
        done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True,
                              timeout=120, check=False)
        self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}{done.stdout}")
        return done.stdout

    def refuses(self, *says):
        """A context in which GDAL must fail, with these texts in its message."""
        return Refusal(self, says)


class Refusal:
    def __init__(self, case, says):
        self.case = case
        self.says = says

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        self.case.assertIsNotNone(error, "GDAL did not fail")
        if kind is not RuntimeError:
            return False
        for part in self.says:
            self.case.assertIn(part, str(error))
        return True


def main():
    if gdal.GetDriverByName("RELIEF") is None:
        sys.exit(f"GDAL found no driver in {os.environ['GDAL_DRIVER_PATH']}: build it")
    harness.main()
