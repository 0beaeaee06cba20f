# SPDX-License-Identifier: MIT
"""Writes a wheel of the Python package with the library inside: wheel.py LIBRARY FOLDER. Prints its path.

The library is not a manylinux one: it loads OpenEXR, teem and others from the system.
"""
import base64
import hashlib
import pathlib
import re
import sys
import sysconfig
import zipfile

TOP = pathlib.Path(__file__).resolve().parent.parent
DATE = (1980, 1, 1, 0, 0, 0)  # the earliest of zip: bytes do not depend on the day


def version():
    header = (TOP / "src/isoshade.h").read_text()
    return ".".join(re.search(rf"ISO_VERSION_{part} (\d+)", header).group(1) for part in ("MAJOR", "MINOR", "PATCH"))


def metadata(number):
    return (f"Metadata-Version: 2.1\nName: isoshade\nVersion: {number}\n"
            "Summary: Levels of detail, pictures and comparisons of scalar volumes\n"
            "License: MIT\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
            "Provides-Extra: all\nRequires-Dist: xarray; extra == 'all'\nRequires-Dist: tqdm; extra == 'all'\n")


def main(library, folder):
    number = version()
    tag = "py3-none-" + re.sub("[-.]", "_", sysconfig.get_platform())
    info = f"isoshade-{number}.dist-info/"
    files = {f"isoshade/{path.name}": path.read_bytes() for path in sorted((TOP / "python/isoshade").glob("*.py*"))
             if path.is_file()}
    files["isoshade/" + pathlib.Path(library).name] = pathlib.Path(library).read_bytes()
    files[info + "LICENSE"] = (TOP / "LICENSE").read_bytes()
    files[info + "METADATA"] = metadata(number).encode()
    files[info + "WHEEL"] = f"Wheel-Version: 1.0\nGenerator: isoshade\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()

    def row(name, data):
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        return f"{name},sha256={digest},{len(data)}\n"

    record = "".join(row(name, data) for name, data in files.items()) + f"{info}RECORD,,\n"
    files[info + "RECORD"] = record.encode()
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    wheel = folder / f"isoshade-{number}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as out:
        for name, data in files.items():
            out.writestr(zipfile.ZipInfo(name, DATE), data, zipfile.ZIP_DEFLATED)
    print(wheel)


main(*sys.argv[1:])
