"""Files in archives, in memory and behind HTTP: only what a window needs is fetched."""

import http.server
import re
import threading
import zipfile

import numpy as np
from osgeo import gdal

from driver_case import DriverCase, band, main, values
from harness import contents_of, hills


class Ranges(http.server.BaseHTTPRequestHandler):
    """Serves the server's `content`, whole or in ranges, and counts the bytes."""

    protocol_version = "HTTP/1.1"

    def do_HEAD(self):
        self.answer(head=True)

    def do_GET(self):
        self.answer(head=False)

    def answer(self, head):
        content = self.server.content
        if not self.path.endswith(".relief"):
            self.send_error(404)
            return
        asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        begin = int(asked[1]) if asked else 0
        end = min(int(asked[2]) if asked and asked[2] else len(content) - 1, len(content) - 1)
        part = content[begin:end + 1]
        self.send_response(206 if asked else 200)
        if asked:
            self.send_header("Content-Range", f"bytes {begin}-{end}/{len(content)}")
        self.send_header("Accept-Ranges", "bytes")
        self.send_header("Content-Length", str(len(part)))
        self.end_headers()
        if not head:
            self.server.sent += len(part)
            self.wfile.write(part)

    def log_message(self, *_):
        pass


class Virtual(DriverCase):
    def test_archive(self):
        original = hills(100, 90).astype("int16")
        file, _ = self.encoded(self.raster("dem.tif", original))
        archive = self.path("dem.zip")
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as out:
            out.write(file, "deep/dem.relief")
        np.testing.assert_array_equal(values(f"/vsizip/{archive}/deep/dem.relief"), original)
        np.testing.assert_array_equal(
            values(f'RELIEF:"/vsizip/{archive}/deep/dem.relief":value'), original)
        # The program reads them too.
        expected, _ = self.decoded(f"/vsizip/{archive}/deep/dem.relief")
        np.testing.assert_array_equal(expected, original)

    def test_subfile(self):
        original = hills(40, 50).astype("int16")
        file, _ = self.encoded(self.raster("dem.tif", original))
        content = contents_of(file)
        gdal.FileFromMemBuffer("/vsimem/more", b"before" + content + b"behind")
        np.testing.assert_array_equal(values(f"/vsisubfile/6_{len(content)},/vsimem/more"),
                                      original)
        gdal.Unlink("/vsimem/more")

    def test_several_threads_have_a_dataset_each(self):
        original = hills(700, 600).astype("int16")
        file, _ = self.encoded(self.raster("dem.tif", original), "--profile", "fast")
        wrong = []

        def read(seed):
            seen = band(file)
            generator = np.random.default_rng(seed)
            for _ in range(20):
                row, col = generator.integers(0, 500, 2)
                window = seen.ReadAsArray(int(col), int(row), 90, 80)
                if not np.array_equal(window, original[row:row + 80, col:col + 90]):
                    wrong.append((seed, row, col))

        threads = [threading.Thread(target=read, args=(seed,)) for seed in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_number_of_threads_does_not_matter(self):
        file, _ = self.encoded(self.raster("dem.tif", hills(700, 600).astype("float32")),
                               "--max-error", 0.5)
        seen = []
        for threads in ("1", "3", "ALL_CPUS"):
            gdal.SetConfigOption("GDAL_NUM_THREADS", threads)
            seen.append(values(file))
        gdal.SetConfigOption("GDAL_NUM_THREADS", None)
        np.testing.assert_array_equal(seen[0], seen[1])
        np.testing.assert_array_equal(seen[0], seen[2])


class Remote(DriverCase):
    def setUp(self):
        super().setUp()
        self.original = hills(1500, 1500).astype("int16")
        file, _ = self.encoded(self.raster("dem.tif", self.original), "--profile", "fast")
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Ranges)
        self.server = server
        server.content = contents_of(file)
        server.sent = 0
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        self.addCleanup(server.server_close)
        self.addCleanup(thread.join)
        self.addCleanup(server.shutdown)
        self.address = f"/vsicurl/http://127.0.0.1:{server.server_port}/dem.relief"
        gdal.SetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR")
        self.addCleanup(gdal.SetConfigOption, "GDAL_DISABLE_READDIR_ON_OPEN", None)
        gdal.VSICurlClearCache()

    def sent(self):
        """Bytes since the last time."""
        sent, self.server.sent = self.server.sent, 0
        return sent

    def test_only_what_a_window_needs_is_fetched(self):
        size = len(self.server.content)
        self.assertGreater(size, 1000000)
        seen = band(self.address)
        # What GDAL itself looks at to find the driver.
        self.assertLessEqual(self.sent(), 49152)

        coarse = seen.GetOverview(3).ReadAsArray()
        self.assertEqual(coarse.shape, (94, 94))
        facts = seen.GetDataset().GetMetadata("RELIEF")
        self.assertLess(self.sent(), int(facts["LEVEL_4_BYTES"]) + 65536)

        window = seen.ReadAsArray(100, 100, 200, 200)
        np.testing.assert_array_equal(window, self.original[100:300, 100:300])
        # One tile of nine, and the coarser ones around it.
        self.assertLess(self.sent(), 0.35 * size)

        np.testing.assert_array_equal(seen.ReadAsArray(110, 120, 50, 60),
                                      self.original[120:180, 110:160])
        self.assertEqual(self.sent(), 0)

    def test_missing(self):
        with self.refuses("404"):
            gdal.Open(self.address.replace("dem.relief", "other"))


if __name__ == "__main__":
    main()
