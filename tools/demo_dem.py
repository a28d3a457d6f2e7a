#!/usr/bin/python3
"""Writes the elevation model of the demonstration as a GeoTIFF.

The model is Jacksboro fault, Tennessee (SRTM, public domain), which Debian's package
python-matplotlib-data carries as a NumPy archive: int16 heights in metres, row 0 in the north,
with its extent in degrees.
"""

import argparse
import os
import sys

SOURCE = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"
PACKAGES = "python3-numpy python3-gdal python-matplotlib-data"


def missing(message):
    sys.exit(f"demo_dem: {message}; install it: apt-get install {PACKAGES}")


try:
    import numpy
    from osgeo import gdal, osr
except ImportError as error:
    missing(f"the Python module '{error.name}' is missing")


def write_geotiff(heights, transform, path):
    rows, cols = heights.shape
    crs = osr.SpatialReference()
    crs.ImportFromEPSG(4326)
    options = ["COMPRESS=DEFLATE", "PREDICTOR=2"]
    dataset = gdal.GetDriverByName("GTiff").Create(path, cols, rows, 1, gdal.GDT_Int16, options)
    dataset.SetGeoTransform(transform)
    dataset.SetSpatialRef(crs)
    band = dataset.GetRasterBand(1)
    band.SetUnitType("m")
    band.WriteArray(heights)
    dataset.FlushCache()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", help="the GeoTIFF to write")
    parser.add_argument("--source", default=SOURCE, help="the NumPy archive (default: %(default)s)")
    arguments = parser.parse_args()

    gdal.UseExceptions()
    if not os.path.exists(arguments.source):
        missing(f"there is no {arguments.source}")
    with numpy.load(arguments.source) as archive:
        heights = archive["elevation"].astype(numpy.int16)
        # The archive calls its northern border ymin.
        west = float(archive["xmin"])
        north = max(float(archive["ymin"]), float(archive["ymax"]))
        transform = (west, float(archive["dx"]), 0.0, north, 0.0, -float(archive["dy"]))

    unfinished = f"{arguments.output}.{os.getpid()}.tif"
    try:
        os.makedirs(os.path.dirname(os.path.abspath(arguments.output)), exist_ok=True)
        write_geotiff(heights, transform, unfinished)
        os.replace(unfinished, arguments.output)
    except (OSError, RuntimeError) as error:
        sys.exit(f"demo_dem: can not write {arguments.output}: {error}")
    finally:
        if os.path.exists(unfinished):
            os.remove(unfinished)


if __name__ == "__main__":
    main()
