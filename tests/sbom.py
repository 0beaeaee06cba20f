# SPDX-License-Identifier: MIT
"""Writes an SBOM (SPDX 2.3, JSON): sbom.py VERSION OUT FILE ... The Debian packages whose libraries the built files load,
directly or not, with their versions."""
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def libraries(files):
    """Returns the paths of all shared libraries that the files load."""
    found = set()
    for file in files:
        found.update(re.findall(r"=> (/\S+) \(", output("ldd", file)))
    return sorted(os.path.realpath(path) for path in found)


def owners(paths):
    """Returns {package: version} of the Debian packages that own the paths."""
    spellings = [*paths, *(path.removeprefix("/usr") for path in paths)]  # older packages list /lib
    found = subprocess.run(("dpkg", "-S", *spellings), capture_output=True, text=True, check=False).stdout
    names = {line.split(": ")[0].split(",")[0] for line in found.splitlines()}
    rows = output("dpkg-query", "-W", "-f", "${Package} ${Version} ${Architecture}\n", *sorted(names)).split("\n")
    return sorted(row.split() for row in rows if row)


def package(name, number, **more):
    return {"SPDXID": "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name), "name": name, "versionInfo": number,
            "downloadLocation": "NOASSERTION", "filesAnalyzed": False, **more}


def main(number, out, *files):
    files = [file for file in files if pathlib.Path(file).is_file()]
    own = package("isoshade", number, licenseDeclared="MIT")
    rows = owners(libraries(files))
    others = [package(name, version, externalRefs=[{
        "referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
        "referenceLocator": f"pkg:deb/debian/{name}@{version}?arch={architecture}"}]) for name, version, architecture in rows]
    digest = hashlib.sha256("".join(" ".join(row) for row in rows).encode()).hexdigest()
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    now = datetime.datetime.fromtimestamp(int(epoch), datetime.timezone.utc) if epoch else datetime.datetime.now(datetime.timezone.utc)
    document = {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"isoshade-{number}",
                "documentNamespace": f"urn:isoshade:{number}:{digest}",
                "creationInfo": {"created": now.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: isoshade-sbom"]},
                "packages": [own, *others],
                "relationships": [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                                   "relatedSpdxElement": own["SPDXID"]}]
                + [{"spdxElementId": own["SPDXID"], "relationshipType": "DYNAMIC_LINK", "relatedSpdxElement": other["SPDXID"]}
                   for other in others]}
    pathlib.Path(out).write_text(json.dumps(document, indent=1) + "\n")
    print(f"{out}: {len(others)} packages")


main(*sys.argv[1:])
