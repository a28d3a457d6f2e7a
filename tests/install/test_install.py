#!/usr/bin/python3
"""Installs the library, moves the tree, and builds programs against it by CMake and by pkg-config.
usage: test_install.py static|shared|package; the environment names RELIEF_BUILD and RELIEF_SOURCE."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BUILD, SOURCE = (pathlib.Path(os.environ[name]) for name in ("RELIEF_BUILD", "RELIEF_SOURCE"))
JOBS = str(os.cpu_count() or 1)
PARTS_NOT_NEEDED = ("APPS", "EDITOR", "TESTS", "EXAMPLES", "BENCH", "PYTHON", "GDAL_DRIVER")


def run(*command, **options) -> str:
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nended with {done.returncode}:\n{done.stdout[-4000:]}")
    return done.stdout


def check_program(command, folder: pathlib.Path, **options) -> None:
    picture = folder / "franke.tif"
    said = run(*command, picture, **options)
    assert "within the bound: yes" in said, said
    assert picture.stat().st_size > 0
    picture.unlink()


def consume(prefix: pathlib.Path, folder: pathlib.Path, shared: bool) -> None:
    """Programs of tests/install/consumer, with and without CMake."""
    work = folder / "consumer"
    libraries = next(prefix.glob("lib/**/cmake/relief")).parent.parent
    run("cmake", "-S", SOURCE / "tests/install/consumer", "-B", work, "-G", "Ninja", "-D", f"CMAKE_PREFIX_PATH={prefix}",
        "-D", "CMAKE_BUILD_TYPE=Release", "-D", "RELIEF_VERSION=0.1")
    run("cmake", "--build", work)
    for name in ("modules", "everything"):
        check_program([work / name], folder)
    wrong = subprocess.run(["cmake", "-S", SOURCE / "tests/install/consumer", "-B", folder / "later", "-D",
                            f"CMAKE_PREFIX_PATH={prefix}", "-D", "RELIEF_VERSION=7"], capture_output=True, text=True)
    assert wrong.returncode != 0 and "compatible" in wrong.stderr, "version 7 is not refused"

    environment = dict(os.environ, PKG_CONFIG_PATH=str(libraries / "pkgconfig"))
    flags = run("pkg-config", "--cflags", "--libs", "relief", env=environment).split()
    program = folder / "by_pkg_config"
    run("c++", "-O1", SOURCE / "tests/install/consumer/consumer.cpp", "-o", program, *flags)
    check_program([program], folder, env=dict(os.environ, LD_LIBRARY_PATH=str(libraries)))
    names = sorted(path.name for path in libraries.glob("librelief_*"))
    assert all((".so" if shared else ".a") in name for name in names) and len(names) >= 7, names


def installed(build: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """The tree is moved after it was installed: nothing in it may name its place."""
    manifest = build / "install_manifest.txt"
    kept = manifest.read_bytes() if manifest.exists() else None
    run("cmake", "--install", build, "--prefix", folder / "first")
    if kept is not None:
        manifest.write_bytes(kept)
    (folder / "first").rename(folder / "moved")
    return folder / "moved"


def check_static(folder: pathlib.Path) -> None:
    prefix = installed(BUILD, folder)
    consume(prefix, folder, shared=False)
    said = run(prefix / "bin/relief", "--version")
    assert said.strip(), said
    (folder / "list.txt").write_text("".join(f"{path}\n" for path in prefix.rglob("*") if not path.is_dir()))
    run(SOURCE / "tools/uninstall", folder / "list.txt")
    assert not prefix.exists(), list(prefix.rglob("*"))


def check_shared(folder: pathlib.Path) -> None:
    build = BUILD / "shared"
    launcher = shutil.which("ccache")
    run("cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release", "-D", "BUILD_SHARED_LIBS=ON",
        *(f"-DRELIEF_{part}=OFF" for part in PARTS_NOT_NEEDED), *([f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}"] if launcher else []))
    run("cmake", "--build", build, "-j", JOBS)
    consume(installed(build, folder), folder, shared=True)


def check_package(folder: pathlib.Path) -> None:
    """The Debian package, unpacked: what it depends on is installed where it was built."""
    if shutil.which("dpkg-shlibdeps") is None:
        print("SKIPPED: dpkg-dev is not installed")
        sys.exit(77)
    run("cpack", "-G", "DEB", "--config", BUILD / "CPackConfig.cmake", "-B", folder)
    package, = folder.glob("relief_*.deb")
    fields = run("dpkg-deb", "--field", package)
    for needed in ("Package: relief", "libgdal", "libc6", "Section: science"):
        assert needed in fields, fields
    run("dpkg-deb", "--extract", package, folder / "root")
    program = folder / "root/usr/bin/relief"
    run(program, "sample", "franke", folder / "franke.tif", "--size", 65)
    run(program, "encode", folder / "franke.tif", folder / "franke.relief", "--max-error", 0.01)
    assert "checksums" in run(program, "info", folder / "franke.relief")
    check_driver(folder / "root", folder / "franke.relief")


def check_driver(root: pathlib.Path, file: pathlib.Path) -> None:
    """It lies where GDAL looks: the folder that the library itself names."""
    drivers = list(root.rglob("gdal_RELIEF.so"))
    if not drivers:
        return  # built without
    library = next(line.split("=> ")[1].split()[0] for line in run("ldd", drivers[0]).splitlines() if "libgdal.so" in line)
    places = re.findall(rb"/[\x21-\x7e]*/gdalplugins", pathlib.Path(library).read_bytes())
    where = "/" + str(drivers[0].parent.relative_to(root))
    assert where.encode() in places, f"{where} is not one of {places}"
    if shutil.which("gdalinfo"):
        told = run("gdalinfo", file, env=dict(os.environ, GDAL_DRIVER_PATH=str(drivers[0].parent)))
        assert "RELIEF" in told, told


def main() -> None:
    checks = {"static": check_static, "shared": check_shared, "package": check_package}
    with tempfile.TemporaryDirectory(prefix="relief-install-") as folder:
        checks[sys.argv[1]](pathlib.Path(folder))


if __name__ == "__main__":
    main()
