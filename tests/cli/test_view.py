"""view: the server of the editor, spoken with as a page does, and as nobody should."""

import contextlib
import http.client
import json
import os
import re
import select
import signal
import socket
import struct
import subprocess
import time

import numpy as np

from harness import NORTH_UP, RELIEF, Case, contents_of, hills, main, read_raster, samples, write_raster
from test_remesh import scan
from websocket import CLOSE, CONTINUATION, TEXT, Closed, Refused, WebSocket


def parts_of(message):
    """The head and the arrays of a binary message."""
    magic, length = struct.unpack_from("<4sI", message)
    assert magic == b"RELF", magic
    head = json.loads(message[8:8 + length])
    types = {"f32": np.float32, "u32": np.uint32, "i16": np.int16, "u8": np.uint8}
    arrays, at = {}, 8 + length
    for array in head["arrays"]:
        assert at % 8 == 0
        values = np.frombuffer(message, types[array["type"]], array["width"] * array["count"], at)
        arrays[array["name"]] = values.reshape(-1, array["width"]) if array["width"] > 1 else values
        at += -(-values.nbytes // 8) * 8
    assert at == len(message)
    return head, arrays


class Page:
    """A WebSocket of the server with the messages that came."""

    def __init__(self, server, headers=None):
        self.socket = WebSocket("127.0.0.1", server.port, server.root + "socket", headers)
        self.last = 0
        self.hello = self.socket.receive()

    def ask(self, question, **members):
        return self.request(ask=question, **members)

    def do(self, command, **members):
        """The answer, and what followed it up to the geometry of the same id."""
        return self.request(do=command, **members)

    def request(self, **message):
        self.last += 1
        self.socket.send({"id": self.last, **message})
        while True:
            answer = self.socket.receive()
            if isinstance(answer, dict) and answer.get("id") == self.last and "ok" in answer:
                return answer

    def event(self, name):
        while True:
            message = self.socket.receive()
            if isinstance(message, dict) and message.get("event") == name:
                return message

    def geometry(self):
        message = self.socket.receive()
        assert isinstance(message, bytes), message
        return parts_of(message)

    def close(self):
        self.socket.close()


class Server:
    """A running `relief view`."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            [RELIEF, "view", *map(str, arguments), "--no-browser", "--json"],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        ready, _, _ = select.select([self.process.stdout], [], [], 60)
        line = self.process.stdout.readline() if ready else ""
        assert line, self.process.stderr.read()
        self.url = json.loads(line)["url"]
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)(/[0-9a-f]{32}/)", self.url)
        assert found, self.url
        self.port, self.root = int(found[1]), found[2]

    def request(self, method, target, body=None, headers=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        with contextlib.closing(connection):
            connection.request(method, target, body, headers or {})
            response = connection.getresponse()
            return response.status, response.read(), dict(response.getheaders())

    def status(self, method, target, **more):
        return self.request(method, target, **more)[0]

    def post(self, target, body):
        status, answer, _ = self.request("POST", self.root + target, body)
        return status, json.loads(answer)

    def end(self, with_signal=None):
        """The exit status and what was said."""
        if with_signal:
            self.process.send_signal(with_signal)
        try:
            out, err = self.process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        return self.process.returncode, out, err


class View(Case):
    def serve(self, *arguments):
        server = Server(*arguments)

        def stop():
            if server.process.poll() is None:
                server.process.kill()
            server.process.communicate()

        self.addCleanup(stop)
        return server

    def dem(self, rows=200, cols=300, **about):
        heights = np.round(hills(rows, cols, rough=0.5) * 100) / 100
        return self.raster("dem.tif", heights.astype(np.float32), transform=NORTH_UP, epsg=32611,
                           unit="m", **about)

    def page(self, server, headers=None):
        page = Page(server, headers)
        self.addCleanup(page.socket.socket.close)
        return page

    def control_point(self, hello, level, down=0.5, across=0.5):
        about = hello["levels"][level]
        return int(about["rows"] * down) * about["cols"] + int(about["cols"] * across)

    # Who may ask

    def test_token_host_and_origin(self):
        server = self.serve(self.dem())
        root = server.root
        status, body, headers = server.request("GET", root, headers={"Accept-Encoding": "gzip"})
        self.assertEqual(status, 200)
        self.assertEqual(headers["Content-Encoding"], "gzip")
        status, body, headers = server.request("GET", root)
        self.assertEqual(status, 200)
        self.assertIn(b"assets/editor.js", body)
        self.assertIn("default-src 'self'", headers["Content-Security-Policy"])
        self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
        self.assertEqual(headers["Referrer-Policy"], "no-referrer")
        self.assertEqual(headers["Cache-Control"], "no-store")
        self.assertEqual(server.status("GET", root + "assets/editor.js"), 200)
        for target in ("/", "/" + "0" * 32 + "/", root[:-1], "/favicon.ico", "*"):
            self.assertEqual(server.status("GET", target), 404, target)
        for target in ("../etc/passwd", "..%2f..%2fetc/passwd", "assets/../index.html", "assets/",
                       "assets//editor.js", "%2e%2e/"):
            self.assertEqual(server.status("GET", root + target), 404, target)
        self.assertEqual(server.status("GET", root, headers={"Host": "example.org"}), 403)
        self.assertEqual(server.status("GET", root, headers={"Origin": "http://example.org"}), 403)
        own = f"http://127.0.0.1:{server.port}"
        self.assertEqual(server.status("GET", root, headers={"Origin": own}), 200)
        for method in ("POST", "PUT", "DELETE", "HEAD"):
            self.assertEqual(server.status(method, root), 405, method)
        self.assertEqual(server.status("GET", root + "socket"), 426)
        self.assertEqual(server.status("GET", root + "drape.png"), 404)
        self.assertEqual(server.status("GET", root, headers={"X": "y" * 70000}), 431)
        for headers in ({"Origin": "http://example.org"}, {"Host": "example.org"}):
            with self.assertRaises(Refused) as refused:
                WebSocket("127.0.0.1", server.port, root + "socket", headers)
            self.assertEqual(refused.exception.status, 403)
        with self.assertRaises(Refused) as refused:
            WebSocket("127.0.0.1", server.port, "/socket")
        self.assertEqual(refused.exception.status, 404)
        self.assertEqual(server.end(signal.SIGINT), (0, "", ""))

    def test_only_this_computer(self):
        server = self.serve(self.dem())
        with open("/proc/net/tcp", encoding="ascii") as table:
            listening = [line.split() for line in table][1:]
        ours = [f[1] for f in listening if f[3] == "0A" and int(f[1].split(":")[1], 16) == server.port]
        self.assertEqual(ours, [f"0100007F:{server.port:04X}"])

    # A page's work

    def test_tiles_are_the_raster(self):
        dem = self.dem(holes := 200, 300)
        server = self.serve(dem)
        page = self.page(server)
        hello = page.hello
        self.assertEqual((hello["event"], hello["kind"], hello["name"]), ("hello", "raster", "dem.tif"))
        self.assertEqual((hello["writer"], hello["bound"], hello["unit"]), (True, 0, "m"))
        self.assertEqual((hello["raster"]["rows"], hello["raster"]["cols"]), (holes, 300))
        self.assertEqual(hello["raster"]["spacing"], [30, 30])
        self.assertTrue(page.ask("view", level=0)["ok"])
        heights = samples(dem)
        side = hello["raster"]["tile"]
        for r, c in ((0, 0), (1, 2)):
            self.assertTrue(page.ask("tiles", tiles=[[0, r, c]])["ok"])
            head, arrays = page.geometry()
            self.assertEqual((head["what"], head["tile"]), ("tile", [0, r, c]))
            part = heights[r * side:(r + 1) * side + 1, c * side:(c + 1) * side + 1]
            self.assertEqual((head["rows"], head["cols"]), part.shape)
            shown = arrays["height"].reshape(part.shape) + hello["origin"][2]
            # 32-bit floats of heights up to 400 relative to the origin.
            np.testing.assert_allclose(shown, part, atol=400 * 2.0**-24)
            self.assertEqual((head["dx"], head["dy"]), (30, -30))
        x = head["x0"] + 2 * head["dx"]
        y = head["y0"] + 3 * head["dy"]
        probe = page.ask("at", x=x, y=y)
        # The surface passes through the samples of a lossless file.
        self.assertAlmostEqual(probe["value"], part[3, 2], delta=1e-6)
        column = (probe["x"] - NORTH_UP[0]) / 30
        self.assertAlmostEqual(column, 2 * side + 2 + 0.5, places=6)

    def test_moves_patch_and_come_back(self):
        server = self.serve(self.dem())
        page = self.page(server)
        page.ask("view", level=0)
        page.ask("tiles", tiles=[[1, 0, 0]])
        head, before = page.geometry()
        point = self.control_point(page.hello, 3, 0.4, 0.3)
        answer = page.do("move", level=3, points=[point], delta=12.5)
        self.assertTrue(answer["ok"], answer)
        changed = page.event("changed")
        self.assertEqual(changed["cause"], answer["id"])
        self.assertEqual((changed["history"]["done"], len(changed["history"]["entries"])), (1, 1))
        patch, arrays = page.geometry()
        self.assertEqual((patch["what"], patch["tile"]), ("patch", [1, 0, 0]))
        row, col, rows, cols = patch["rect"]
        grid = before["height"].reshape(head["rows"], head["cols"]).copy()
        moved = arrays["height"].reshape(rows, cols)
        self.assertGreater(np.max(moved - grid[row:row + rows, col:col + cols]), 5)
        grid[row:row + rows, col:col + cols] = moved
        page.ask("tiles", tiles=[[1, 0, 0]])
        _, after = page.geometry()
        np.testing.assert_array_equal(after["height"], grid.ravel())
        page.do("undo")
        self.assertEqual(page.event("changed")["history"]["done"], 0)
        _, back = page.geometry()
        page.ask("tiles", tiles=[[1, 0, 0]])
        _, again = page.geometry()
        for name, values in before.items():
            np.testing.assert_array_equal(again[name], values, name)
        page.do("redo")
        self.assertEqual(page.event("changed")["history"]["done"], 1)
        page.geometry()
        page.ask("tiles", tiles=[[1, 0, 0]])
        _, redone = page.geometry()
        np.testing.assert_array_equal(redone["height"], after["height"])

    def test_save_and_script(self):
        dem = self.dem()
        server = self.serve(dem)
        page = self.page(server)
        for level, delta in ((3, 12.5), (1, -2.25)):
            point = self.control_point(page.hello, level, 0.3, 0.6)
            self.assertTrue(page.do("move", level=level, points=[point], delta=delta)["ok"])
        self.assertEqual(page.hello["save"], "dem-edited.relief")
        saved = page.ask("save")
        self.assertEqual(saved["path"], self.path("dem-edited.relief"))
        self.assertEqual(saved["bytes"], os.path.getsize(saved["path"]))
        self.assertEqual(self.json("info", saved["path"])["edits"], 2)

        status, script, _ = server.request("GET", server.root + "export?format=script")
        self.assertEqual(status, 200)
        self.assertEqual([c["level"] for c in json.loads(script)], [3, 1])
        status, relief, headers = server.request("GET", server.root + "export?format=relief")
        self.assertEqual((status, relief), (200, contents_of(saved["path"])))
        self.assertEqual(headers["Content-Disposition"], "attachment; filename*=UTF-8''dem-edited.relief")
        self.assertEqual(self.listing(), [self.path("dem-edited.relief"), dem])

        # The same moves by the command line give the same surface.
        plain, _ = self.encoded(dem, "--profile", "fast", name="plain.relief")
        moves = [{"level": c["level"], "index": c["points"][0], "delta": c["delta"][2]}
                 for c in json.loads(script)]
        with open(self.path("moves.json"), "w", encoding="utf-8") as file:
            json.dump(moves, file)
        self.json("edit", plain, self.path("edited.relief"), "--script", self.path("moves.json"))
        self.assertEqual(contents_of(self.path("edited.relief")), relief)

    def test_save_where_asked(self):
        server = self.serve(self.dem(), "--save", self.path("valley.relief"))
        page = self.page(server)
        self.assertEqual(page.hello["save"], "valley.relief")
        self.assertEqual(page.ask("save")["path"], self.path("valley.relief"))
        self.assertTrue(os.path.exists(self.path("valley.relief")))

    def test_exports_of_a_raster(self):
        dem = self.dem(90, 120)
        server = self.serve(dem)
        page = self.page(server)
        page.ask("view", level=1)
        status, tif, headers = server.request("GET", server.root + "export?format=tif")
        self.assertEqual((status, headers["Content-Type"]), (200, "image/tiff"))
        with open(self.path("shown.tif"), "wb") as file:
            file.write(tif)
        shown = read_raster(self.path("shown.tif"))
        encoded, _ = self.encoded(dem, "--profile", "fast")
        self.json("decode", encoded, self.path("level1.tif"), "--level", 1)
        expected = read_raster(self.path("level1.tif"))
        np.testing.assert_array_equal(shown.planes[0], expected.planes[0])
        self.assertEqual((shown.transform, shown.wkt), (expected.transform, expected.wkt))
        status, obj, _ = server.request("GET", server.root + "export?format=obj")
        self.assertEqual(status, 200)
        vertices = np.array([line.split()[1:] for line in obj.decode().splitlines()
                             if line.startswith("v ")], float)
        np.testing.assert_array_equal(vertices[:, 2].reshape(shown.planes[0].shape), shown.planes[0])
        t = shown.transform
        np.testing.assert_allclose(vertices[1, :2], [t[0] + 1.5 * t[1], t[3] + 0.5 * t[5]])
        for form in ("glb", "ply"):
            self.assertEqual(server.status("GET", server.root + f"export?format={form}"), 200)
        status, error, _ = server.request("GET", server.root + "export?format=exe")
        self.assertEqual((status, json.loads(error)["code"]), (422, "invalid_argument"))

    def test_open_another_file(self):
        server = self.serve(self.dem())
        page = self.page(server)
        other = write_raster(self.path("other.tif"), np.round(hills(40, 50)).astype(np.int16))
        self.assertEqual(server.post("open?name=other.tif", contents_of(other)), (200, {}))
        hello = page.event("hello")
        self.assertEqual((hello["name"], hello["save"]), ("other.tif", ""))
        self.assertEqual((hello["raster"]["rows"], hello["raster"]["cols"]), (40, 50))
        self.assertEqual(page.ask("save")["error"]["code"], "invalid_argument")
        status, error = server.post("open?name=bad.tif", b"no raster at all")
        self.assertEqual(status, 422)
        self.assertTrue(error["message"])
        status, error = server.post("open?name=bad.relief", b"RELIEF\x89" + b"x" * 100)
        self.assertEqual((status, error["code"]), (422, "bad_file"))
        for name in ("..%2Fother.tif", "%2Fetc%2Fpasswd", ".hidden", ""):
            self.assertEqual(server.status("POST", server.root + "open?name=" + name, body=b"x"), 400)
        # What was open stays.
        self.assertTrue(page.ask("view", level=0)["ok"])

    def test_files_that_refer_to_others_are_not_followed(self):
        dem = self.dem()
        server = self.serve(dem)
        vrt = f"""<VRTDataset rasterXSize="300" rasterYSize="200"><VRTRasterBand dataType="Float32" band="1">
            <SimpleSource><SourceFilename>{dem}</SourceFilename><SourceBand>1</SourceBand></SimpleSource>
            </VRTRasterBand></VRTDataset>"""
        for target in ("open?name=x.vrt", "open?name=x.tif", "drape?name=x.png", "drape?name=x.vrt"):
            status, error = server.post(target, vrt.encode())
            self.assertEqual((status, error["code"]), (422, "bad_input"), target)

    def test_drape(self):
        dem = self.dem()
        server = self.serve(dem)
        # East half red, and green where the terrain is not.
        rows, cols = 200, 600
        red = np.zeros((rows, cols), np.uint8)
        red[:, 150:300] = 255
        green = np.zeros((rows, cols), np.uint8)
        green[:, 300:] = 255
        write_raster(self.path("image.tif"), [red, green, 0 * red], transform=NORTH_UP, epsg=32611)
        status, answer = server.post("drape?name=image.tif", contents_of(self.path("image.tif")))
        self.assertEqual(status, 200, answer)
        x0, y0, x1, y1 = answer["rect"]
        self.assertAlmostEqual(x1 - x0, 300 * 30)
        self.assertAlmostEqual(y1 - y0, 200 * 30)
        status, png, headers = server.request("GET", server.root + "drape.png")
        self.assertEqual((status, headers["Content-Type"]), (200, "image/png"))
        with open(self.path("drape.png"), "wb") as file:
            file.write(png)
        planes = read_raster(self.path("drape.png")).planes
        height, width = planes[0].shape
        self.assertLess(abs(width / height - 1.5), 0.01)
        inside = width - 1  # the last column is mixed with what lies beyond
        self.assertEqual(planes[1][:, :inside].max(), 0)
        self.assertEqual(planes[0][:, :width // 2 - 2].max(), 0)
        self.assertEqual(planes[0][:, width // 2 + 2:inside].min(), 255)
        self.assertEqual(planes[3].min(), 255)

    # Several pages, and their end

    def test_one_writes_and_others_watch(self):
        server = self.serve(self.dem())
        writer = self.page(server)
        watcher = self.page(server)
        self.assertEqual((writer.hello["writer"], watcher.hello["writer"]), (True, False))
        point = self.control_point(writer.hello, 3)
        refused = watcher.do("move", level=3, points=[point], delta=1)
        self.assertEqual(refused["error"]["code"], "read_only")
        self.assertEqual(watcher.ask("save")["error"]["code"], "read_only")
        watcher.ask("view", level=2)
        watcher.ask("tiles", tiles=[[2, 0, 0]])
        _, before = watcher.geometry()
        self.assertTrue(writer.do("move", level=3, points=[point], delta=40)["ok"])
        self.assertIsNone(watcher.event("changed")["cause"])
        head, after = watcher.geometry()
        self.assertEqual((head["what"], head["tile"]), ("tile", [2, 0, 0]))
        self.assertGreater(np.max(after["height"] - before["height"]), 5)
        writer.close()
        self.assertTrue(self.page(server).hello["writer"])

    def test_ends_with_the_page(self):
        server = self.serve(self.dem(60, 80))
        time.sleep(3.5)  # before the first page there is no end
        page = self.page(server)
        page.close()
        time.sleep(1)
        page = self.page(server)  # a reload
        self.assertTrue(page.hello["writer"])
        time.sleep(3)
        self.assertTrue(page.ask("view", level=0)["ok"])
        page.close()
        self.assertEqual(server.end(), (0, "", ""))

    def test_signals_end_it(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            server = self.serve(self.dem(60, 80))
            page = self.page(server)
            server.process.send_signal(number)
            self.assertEqual(page.socket.receive(), {"event": "closing"})
            with self.assertRaises(Closed) as closed:
                page.socket.receive()
            self.assertEqual(closed.exception.code, 1001)
            self.assertEqual(server.end(), (0, "", ""))

    def test_port_is_taken(self):
        server = self.serve(self.dem(60, 80))
        self.refuse(1, "view", self.path("dem.tif"), "--no-browser", "--port", server.port,
                    says=(f"port {server.port}", "--port"))

    def test_bad_files_are_refused(self):
        self.refuse(1, "view", self.path("missing.tif"), "--no-browser", says="missing.tif")
        with open(self.path("bad.relief"), "wb") as file:
            file.write(b"RELIEF\x89" + b"x" * 50)
        self.refuse(1, "view", self.path("bad.relief"), "--no-browser", says="bad.relief")

    def mesh(self, name, points, faces):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.writelines("v {} {} {}\n".format(*p) for p in points)
            file.writelines("f {} {} {}\n".format(*(c + 1 for c in f)) for f in faces)
        return self.path(name)

    def test_meshes_without_levels_are_remeshed(self):
        points, faces = scan(30)
        server = self.serve(self.mesh("scan.obj", points, faces))
        page = self.page(server)
        self.assertEqual(page.hello["kind"], "mesh")
        self.assertGreater(len(page.hello["levels"]), 1)
        self.assertIn("scan.obj is no subdivision", page.event("notice")["message"])
        # What is shown has the shape of the file, within what remeshing keeps to.
        status, ply, _ = server.request("GET", server.root + "export?format=ply")
        self.assertEqual(status, 200)
        with open(self.path("shown.ply"), "wb") as file:
            file.write(ply)
        far = self.json("compare", self.path("scan.obj"), self.path("shown.ply"), "--surface")
        self.assertLessEqual(far["max_error"], 2e-3 * np.linalg.norm(np.ptp(points, axis=0)))

    def test_machine_parts_are_remeshed_with_their_edges(self):
        # Without its edges kept, two levels of a tetrahedron are farther away than remeshing allows.
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        path = self.mesh("part.obj", corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
        self.refuse(1, "remesh", path, self.path("no.obj"), says="tolerance_not_met")
        page = self.page(self.serve(path))
        self.assertIn("part.obj is no subdivision", page.event("notice")["message"])

    def test_meshes_that_can_not_be_remeshed_are_named_a_remedy(self):
        rough = self.mesh("rough.obj", *scan(8, noise=0.4))
        self.refuse(1, "view", rough, "--no-browser",
                    says=("rough.obj", "'relief subdivide'", "'relief remesh'", "tolerance_not_met"))
        torn = self.mesh("torn.obj", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)],
                         [(0, 1, 2), (0, 1, 3), (0, 1, 4)])
        self.refuse(1, "view", torn, "--no-browser", says=("torn.obj", "non_manifold"))

    def test_a_page_that_does_not_read_is_dropped(self):
        server = self.serve(self.dem())
        page = self.page(server)
        page.ask("view", level=0)
        for number in range(100, 103):  # 200 MB each
            page.socket.send({"id": number, "ask": "tiles", "tiles": [[0, 0, 0]] * 1024})
        other = self.page(server)
        self.assertFalse(other.hello["writer"])
        other.ask("at", x=0, y=0)  # comes after all of it
        with open(f"/proc/{server.process.pid}/status", encoding="ascii") as status:
            resident = int(re.search(r"VmHWM:\s+(\d+) kB", status.read())[1])
        if not {"ASAN_OPTIONS", "TSAN_OPTIONS"} & set(os.environ):  # sanitizers keep memory of their own
            self.assertLess(resident, 600_000)
        self.assertTrue(self.page(server).hello["writer"])

    # Nonsense

    def test_malformed_messages(self):
        server = self.serve(self.dem(60, 80))
        page = self.page(server)
        for text in (b"", b"x", b"[1]", b"{}", b'{"id": 1}', b"[" * 100000):
            page.socket.send_frame(TEXT, text)
            answer = page.socket.receive()
            self.assertEqual((answer["id"], answer["ok"]), (None, False), text[:20])
        whole = json.dumps({"id": 50, "ask": "view", "level": 0}).encode()
        page.socket.send_frame(TEXT, whole[:10], final=False)
        page.socket.send_frame(CONTINUATION, whole[10:20], final=False)
        page.socket.send_frame(CONTINUATION, whole[20:])
        self.assertEqual(page.socket.receive()["id"], 50)

    def test_malformed_frames(self):
        server = self.serve(self.dem(60, 80))
        nonsense = {
            "unmasked": (1002, lambda s: s.send_frame(TEXT, b"{}", masked=False)),
            "unknown opcode": (1002, lambda s: s.send_frame(5, b"")),
            "continues nothing": (1002, lambda s: s.send_frame(CONTINUATION, b"x")),
            "long control frame": (1002, lambda s: s.send_frame(9, b"x" * 200)),
            "reserved bit": (1002, lambda s: s.socket.sendall(b"\xC1\x80\0\0\0\0")),
            "no UTF-8": (1007, lambda s: s.send_frame(TEXT, b"\xff\xfe")),
            "binary": (1003, lambda s: s.send_frame(2, b"x")),
            "too large": (1009, lambda s: s.socket.sendall(struct.pack(">BBQ", 0x81, 0xFF, 1 << 40) + b"\0" * 4)),
            "bad close": (1002, lambda s: s.send_frame(CLOSE, b"\x00")),
        }
        for name, (code, send) in nonsense.items():
            page = self.page(server)
            send(page.socket)
            with self.assertRaises(Closed, msg=name) as closed:
                while True:
                    page.socket.receive()
            self.assertIn(closed.exception.code, (code, None), name)
            page.socket.socket.close()
        self.assertTrue(self.page(server).hello)

    def test_broken_requests(self):
        server = self.serve(self.dem(60, 80))
        for text in (b"\r\n\r\n", b"nonsense\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\0" * 1000,
                     b"POST " + server.root.encode() + b"open?name=x HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n"
                     b"Content-Length: 99999999999\r\n\r\n" % server.port):
            with socket.create_connection(("127.0.0.1", server.port), 10) as client:
                with contextlib.suppress(ConnectionError):
                    client.sendall(text)
                    while client.recv(1 << 16):
                        pass
        self.assertEqual(server.status("GET", server.root), 200)


if __name__ == "__main__":
    main()
