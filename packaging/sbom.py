#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The bill of materials of a build, as SPDX 2.3 in JSON: what is linked, with version and licence.

    sbom.py VERSION COMMIT SECONDS < LIBRARIES     SECONDS since 1970: the time of the commit; LIBRARIES: a path a line

Versions are dpkg's, or package-lock.json's for what npm brings. Licences are those of docs/licences.md by their SPDX
names where that page knows them; what a library without one is under stands in its Debian package, as the bill says.
"""
import datetime
import json
import pathlib
import re
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[1]
# Compiled in: headers, and the scripts of the page.
HEADERS = ("libeigen3-dev", "nlohmann-json3-dev", "libcli11-dev", "libboost1.74-dev", "pybind11-dev")
SCRIPTS = {"uplot": "MIT", "three": "MIT"}
# Of packages, else of their source packages. Of CHOLMOD, what its Supernodal module asks for.
LICENCES = {"libamd2": "BSD-3-Clause", "libcolamd2": "BSD-3-Clause", "libcamd2": "BSD-3-Clause", "libccolamd2": "BSD-3-Clause",
            "eigen3": "MPL-2.0", "nlohmann-json3": "MIT", "cli11": "BSD-3-Clause", "boost1.74": "BSL-1.0",
            "pybind11": "BSD-3-Clause", "suitesparse": "GPL-2.0-or-later", "metis": "Apache-2.0",
            "openblas": "BSD-3-Clause", "pagmo": "GPL-3.0-or-later OR LGPL-3.0-or-later", "onetbb": "Apache-2.0",
            "gcc-12": "GPL-3.0-or-later WITH GCC-exception-3.1", "hdf5": "BSD-3-Clause", "zlib": "Zlib",
            "openssl": "Apache-2.0", "yaml-cpp": "MIT", "fmtlib": "MIT", "muparser": "MIT", "mosquitto": "EPL-2.0 OR BSD-3-Clause",
            "libsndfile": "LGPL-2.1-or-later", "libmatio": "BSD-2-Clause"}


def dpkg(*arguments):
    return subprocess.run(["dpkg-query", *arguments], check=True, capture_output=True, text=True).stdout


def package_of(file):
    """The Debian package that a file belongs to; a link of the alternatives, or of merged /usr, under its other name."""
    for name in (file, file.removeprefix("/usr")):
        found = subprocess.run(["dpkg-query", "-S", name], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.split(": ")[0]
    sys.exit(f"sbom.py: no Debian package holds {file}")


def spdx_id(name):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name)


def entry(name, version, licence, locator, comment=None):
    package = {"SPDXID": spdx_id(f"{name}-{version}"), "name": name, "versionInfo": version, "downloadLocation": "NOASSERTION",
               "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": licence,
               "copyrightText": "NOASSERTION"}
    if locator:
        package["externalRefs"] = [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": locator}]
    return package | ({"comment": comment} if comment else {})


def debian_entry(package):
    name, version, source, architecture = dpkg("-W", "-f=${Package}\t${Version}\t${source:Package}\t${Architecture}", package).split("\t")
    comment = f"Debian's source package {source}; licences: /usr/share/doc/{name}/copyright"
    locator = f"pkg:deb/debian/{name}@{version.replace('+', '%2B').replace(':', '%3A')}?arch={architecture}&distro=debian-12"
    return entry(name, version, LICENCES.get(name, LICENCES.get(source, "NOASSERTION")), locator, comment)


def script_entry(name, licence):
    version = json.loads((PROJECT / "package.json").read_text())["dependencies"][name]
    return entry(name, version, licence, f"pkg:npm/{name}@{version}")


def bill(version, commit, time, libraries):
    linked = sorted({package_of(file) for file in libraries})
    own = entry("kalfem", version, "Apache-2.0", None, f"built from commit {commit}") | {"licenseConcluded": "GPL-3.0-or-later"}
    dynamic = [debian_entry(package) for package in linked]
    inside = [debian_entry(package) for package in HEADERS] + [script_entry(*each) for each in SCRIPTS.items()]
    document = "SPDXRef-DOCUMENT"
    relationships = [(document, "DESCRIBES", own), *((own["SPDXID"], "DYNAMIC_LINK", each) for each in dynamic),
                     *((own["SPDXID"], "CONTAINS", each) for each in inside)]
    return {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": document, "name": f"kalfem-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/kalfem-{version}-{commit}",
        "creationInfo": {"created": time.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: kalfem-sbom"]},
        "packages": [own, *dynamic, *inside],
        "relationships": [{"spdxElementId": a, "relationshipType": kind, "relatedSpdxElement": b["SPDXID"]}
                          for a, kind, b in relationships]}


def main():
    version, commit, seconds = sys.argv[1:]
    time = datetime.datetime.fromtimestamp(int(seconds), datetime.timezone.utc)
    print(json.dumps(bill(version, commit, time, sys.stdin.read().split()), indent=1))


if __name__ == "__main__":
    main()
