#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# make wheel: its wheel is installed without a network, and draws with its own library. make sbom: its file has the keys
# of SPDX 2.3, and names the packages of the libraries that the program loads.
. "$(dirname "$0")/lib.sh"
unset MAKEFLAGS MFLAGS # of the make that runs the tests
make_it() { make -s -C "$top" SETUP=no config=release "$@"; }

expect a_wheel_is_made 0 make_it wheel
wheel=$top/$(tail -n 1 out)
"$ISOSHADE" make shells --size 16 -q -o shells.nrrd || exit 1
python_with numpy,ensurepip
if "$python" -c 'import numpy, ensurepip' 2>/dev/null; then
    "$python" -m venv --system-site-packages env >/dev/null || exit 1
    find env | sort >before
    expect it_is_installed_without_a_network 0 env/bin/python3 -m pip install -q --no-index --no-deps "$wheel"
    cat >picture.py <<'END_PYTHON'
import pathlib
import isoshade as iso
assert pathlib.Path(iso.__file__).is_relative_to(pathlib.Path("env").resolve()), iso.__file__
image = iso.open("shells.nrrd").build(levels=1).render(size=32)
assert image.shape == (32, 32, 4) and image.std() > 0.01, "the picture is empty"
loaded = {line.split()[-1] for line in open("/proc/self/maps") if "libisoshade" in line}
assert len(loaded) == 1 and "/env/" in loaded.pop(), loaded
END_PYTHON
    draws() { env/bin/python3 picture.py; }
    check it_draws_with_its_own_library draws
    library=$(ls env/lib/python3*/site-packages/isoshade/libisoshade.so.*)
    mv "$library" kept
    notice a_wheel_without_the_library_would_be_seen draws
    mv kept "$library"
    expect it_is_removed 0 env/bin/python3 -m pip uninstall -q -y isoshade
    check and_leaves_no_file diff before <(find env | sort)
else
    skip it_is_installed_without_a_network "no python3-numpy or no python3-venv"
fi

expect an_sbom_is_written 0 make_it sbom
cat >spdx.py <<'END_PYTHON'
import json
import re
import sys
d = json.load(open(sys.argv[1]))
assert d["spdxVersion"] == "SPDX-2.3" and d["dataLicense"] == "CC0-1.0"
assert d["SPDXID"] == "SPDXRef-DOCUMENT" and d["name"]
assert re.fullmatch(r"[a-z]+:[^#\s]+", d["documentNamespace"])
assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", d["creationInfo"]["created"]), d["creationInfo"]
assert all(re.match("(Tool|Person|Organization): ", creator) for creator in d["creationInfo"]["creators"])
ids = [package["SPDXID"] for package in d["packages"]]
assert len(set(ids)) == len(ids) and all(re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", i) for i in ids), ids
assert all(package["name"] and package["versionInfo"] and package["downloadLocation"] for package in d["packages"])
ends = {row[key] for row in d["relationships"] for key in ("spdxElementId", "relatedSpdxElement")}
assert ends == {*ids, "SPDXRef-DOCUMENT"}, ends ^ {*ids, "SPDXRef-DOCUMENT"}
names = {package["name"] for package in d["packages"]}
wanted = set(open(sys.argv[2]).read().split())
assert wanted and wanted <= names, wanted - names
END_PYTHON
# A package lists a path with /usr; older ones list some without.
ldd "$ISOSHADE" | grep -o '=> /[^ ]*' | cut -c 4- | xargs realpath >paths
dpkg -S $(cat paths) $(sed 's|^/usr||' paths) 2>/dev/null | sed 's/:.*//' | sort -u >owners
holds_together() { python3 spdx.py "$1" owners; }
check it_has_the_keys_and_the_packages holds_together "$top/build/isoshade.spdx.json"
plant() { python3 -c "import json, sys
d = json.load(open('$top/build/isoshade.spdx.json'))
$1
json.dump(d, open('bad.json', 'w'))"; }
plant 'd["packages"] = [p for p in d["packages"] if p["name"] != "libjansson4"]'
notice a_package_that_is_missing_would_be_seen holds_together bad.json
plant 'd["packages"][1]["SPDXID"] = d["packages"][2]["SPDXID"]'
notice an_identifier_that_occurs_twice_would_be_seen holds_together bad.json
exit $failed
