#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Installs what scripts/package has made where nothing of this system is: in bare roots of Debian 12 by debootstrap,
without a compiler. There each runs a measured record; the wheel also the Python lines of README.md. Prints sizes,
seconds and processor seconds. Last, the results of twelve records for each width of vectors.

    bare_debian.py PACKAGES      needs root, debootstrap and the Debian mirror; exit code 77 where one is absent
"""
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time

PROJECT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "tests/docs"))
from page_blocks import blocks_of_text  # noqa: E402

MIRROR = "http://deb.debian.org/debian"
C_LIBRARY = r"/lib(64)?/(x86_64-linux-gnu/)?(ld-linux-x86-64|lib(c|m|pthread|dl|rt|resolv))\.so\.\d"
LARGEST_WHEEL = 40e6  # [bytes]


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def require(holds, what):
    if not holds:
        sys.exit(f"FAILED: {what}")
    print(f"ok: {what}", flush=True)


def one(packages, pattern):
    found = sorted(packages.glob(pattern))
    if len(found) != 1:
        sys.exit(f"{packages} has {len(found)} files {pattern}: scripts/package make")
    return found[0]


class Root:
    """A folder with a whole system, in which commands run."""

    def __init__(self, folder):
        self.folder = folder

    def copy(self, name):
        subprocess.run(["cp", "-a", self.folder, self.folder.parent / name], check=True)
        return Root(self.folder.parent / name)

    def put(self, file, place):
        (self.folder / place).mkdir(parents=True, exist_ok=True)
        shutil.copy(file, self.folder / place)

    def run(self, command, code=0, place="/root"):
        """What a shell in the root prints, and the seconds and processor seconds that it takes."""
        inside = f"mount -t proc proc {self.folder}/proc 2>/dev/null; exec chroot {self.folder} /bin/sh -c {shlex.quote(f'cd {place} && {command}')}"
        settings = {"PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8",
                    "DEBIAN_FRONTEND": "noninteractive"} | {name: value for name, value in os.environ.items() if name.endswith("_proxy")}
        start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(["unshare", "--mount", "sh", "-c", inside], env=settings, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != code:
            sys.exit(f"FAILED in {self.folder.name}: {command}\nexit code {done.returncode}, expected {code}\n{done.stdout}{done.stderr}")
        done.seconds = time.perf_counter() - start
        done.processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return done

    def without_compiler(self):
        found = self.run("command -v cc gcc g++ c++ clang clang-16 make cmake || true").stdout
        require(not found, f"{self.folder.name}: no compiler {found}")

    def outside(self, program):
        """Libraries that a program takes from the system, by their paths."""
        listed = self.run(f"ldd {program}").stdout
        return sorted(set(re.findall(r"(?:=> |^\s*)(/\S+) \(0x", listed, re.MULTILINE)))


def bare_root(folder, cache):
    cache.mkdir(parents=True, exist_ok=True)
    command = ["debootstrap", "--variant=minbase", f"--cache-dir={cache}", "bookworm", folder, MIRROR]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        skip(f"debootstrap cannot make a Debian 12 from {MIRROR}: {done.stdout[-300:]}{done.stderr[-300:]}")
    return Root(folder)


def measured_record(root, kalfem, what):
    """A newcomer's first commands."""
    told = root.run(f"{kalfem} new measured x && {kalfem} run x/case.yaml")
    require("Verdict: consistent" in told.stdout, f"{what}: kalfem new, run: consistent in {told.seconds:.1f} s, {told.processor:.1f} s of processor")
    require((root.folder / "root/x/case.kalfem-out/report.html").stat().st_size > 100000, f"{what}: the page of the run is there")


def steps_of(dockerfile):
    text = "\n".join(line for line in dockerfile.read_text().splitlines() if not line.startswith("#"))
    return [line.split(None, 1) for line in text.replace("\\\n", " ").splitlines() if line.strip()]


def follow_dockerfile(root, packages):
    """Does in the root what docker would: its image debian:12-slim is such a root."""
    entry, words = [], []
    place = "/"
    for step, rest in steps_of(PROJECT / "packaging/Dockerfile"):
        if step == "FROM":
            require(rest == "debian:12-slim", f"Dockerfile: {step} {rest}")
        elif step == "COPY":
            pattern, target = rest.split()
            root.put(one(packages, pattern), target.lstrip("/"))
        elif step == "RUN":
            root.run(f"apt-get update -qq && apt-get install -y -qq --no-install-recommends --download-only /tmp/kalfem_*.deb")
            downloaded = sum(file.stat().st_size for file in (root.folder / "var/cache/apt/archives").glob("*.deb"))
            told = root.run(rest, place=place)
            print(f"    installs in {told.seconds:.1f} s, {told.processor:.1f} s of processor, with {downloaded / 1e6:.1f} MB of Debian's packages")
        elif step == "WORKDIR":
            place = rest
            (root.folder / rest.lstrip("/")).mkdir(exist_ok=True)
        elif step in ("ENTRYPOINT", "CMD"):
            (entry if step == "ENTRYPOINT" else words).extend(json.loads(rest))
        else:
            sys.exit(f"FAILED: Dockerfile: {step} is no instruction that this test knows")
    require("kalfem" in root.run(shlex.join(entry + words), place=place).stdout, f"Dockerfile: {shlex.join(entry + words)}")


def check_debian_package(root, packages):
    follow_dockerfile(root, packages)
    root.without_compiler()
    require("commit" in root.run("kalfem --version").stdout, root.run("kalfem --version").stdout.strip())
    measured_record(root, "kalfem", "package")
    for file in ("share/man/man1/kalfem.1.gz", "share/bash-completion/completions/kalfem", "share/kalfem/kalfem.schema.json",
                 "share/doc/kalfem/copyright", "share/doc/kalfem/docs/start.md", "share/doc/kalfem/examples/start/measured/case.yaml"):
        require((root.folder / "usr" / file).exists(), f"package: {file}")
    completed = root.run("bash -c '. /usr/share/bash-completion/completions/kalfem; COMP_WORDS=(kalfem ru); COMP_CWORD=1; _kalfem; echo $COMPREPLY'")
    require(completed.stdout.strip() == "run", "package: bash completes kalfem ru")
    root.run("apt-get remove -y -qq kalfem")
    require(not list((root.folder / "usr").rglob("*kalfem*")), "package: nothing of it is left behind when it is removed")


def check_archive(root, packages):
    archive = one(packages, "kalfem-*.tar.xz")
    with tarfile.open(archive) as opened:
        opened.extractall(root.folder / "opt")
    folder = one(root.folder / "opt", "kalfem-*")
    folder.rename(folder.parent / "moved here")
    root.run("ln -s '/opt/moved here/bin/kalfem' /usr/local/bin/kalfem")
    root.without_compiler()
    measured_record(root, "kalfem", "archive")
    outside = [path for path in root.outside("'/opt/moved here/lib/kalfem/kalfem'") if not path.startswith("/opt")]
    require(all(re.fullmatch(C_LIBRARY, path) for path in outside), f"archive: from outside only {', '.join(outside)}")
    root.run("mkdir /old && printf '#!/bin/sh\\necho glibc 2.31\\n' >/old/getconf && chmod 755 /old/getconf")
    refused = root.run("PATH=/old:$PATH kalfem --version", code=1).stderr
    require(refused.count("\n") == 1 and "and this system has 2.31" in refused, f"archive: {refused.strip()}")


def check_references(folder, packages):
    """The archive's command gives the committed results, for each width of vectors that this processor has."""
    with tarfile.open(one(packages, "kalfem-*.tar.xz")) as opened:
        opened.extractall(folder / "archive-here")
    kalfem = next((folder / "archive-here").glob("kalfem-*/bin/kalfem"))
    flags = pathlib.Path("/proc/cpuinfo").read_text().split()
    for width in ["baseline"] + (["avx2"] if "avx2" in flags else []) + ["native"]:
        settings = {name: value for name, value in os.environ.items() if name != "KALFEM_CPU"}
        if width != "native":
            settings["KALFEM_CPU"] = width
        done = subprocess.run([sys.executable, PROJECT / "tools/reference_results.py", "check", "--command", kalfem],
                              env=settings, capture_output=True, text=True)
        require(done.returncode == 0, f"reference results at {width}: {(done.stdout + done.stderr).strip()}")


def readme_blocks():
    """What a newcomer types: the shell block with `kalfem new`, and the Python lines."""
    blocks = blocks_of_text((PROJECT / "README.md").read_text())
    shell = [block.text for block in blocks if block.language == "sh" and "kalfem new" in block.text]
    python = [block.text for block in blocks if block.language == "python"]
    require(len(shell) == 1 and python, "README.md shows kalfem new, and Python lines")
    return shell[0], "".join(python)


def check_wheel(root, packages):
    wheel = one(packages, "kalfem-*.whl")
    size = wheel.stat().st_size
    require(size < LARGEST_WHEEL, f"wheel: {wheel.name} has {size / 1e6:.1f} MB, under {LARGEST_WHEEL / 1e6:.0f}")
    root.put(wheel, "root")
    root.run("apt-get update -qq && apt-get install -y -qq --no-install-recommends python3-venv python3-numpy")
    root.run("python3 -m venv --system-site-packages venv")
    installed = root.run(f"venv/bin/pip install -q --no-index {wheel.name}")
    print(f"    installs in {installed.seconds:.1f} s, {installed.processor:.1f} s of processor")
    root.without_compiler()
    measured_record(root, "venv/bin/kalfem", "wheel")
    shell, python = readme_blocks()
    root.run(f"export PATH=/root/venv/bin:$PATH; {shell}")
    (root.folder / "root/readme.py").write_text(python)
    told = root.run("venv/bin/python readme.py")
    require(told.stdout.strip(), f"wheel: README.md's Python lines run in {told.seconds:.1f} s and print {told.stdout.strip()[:60]!r}")
    outside = [path for path in root.outside("/root/venv/lib/python3*/site-packages/kalfem/_core*.so") if not path.startswith("/root/venv")]
    require(all(re.fullmatch(C_LIBRARY, path) for path in outside), f"wheel: from outside only {', '.join(outside)}")
    for wrong in ("--python-version 3.12", "--platform manylinux_2_31_x86_64"):
        refused = root.run(f"venv/bin/pip install -q --no-index --no-deps --only-binary=:all: --target other {wrong} {wheel.name}", code=1).stderr
        require(refused.count("\n") == 1 and "is not a supported wheel" in refused, f"wheel, {wrong}: {refused.strip()}")


def check_development_package(folder, packages):
    """The C++ libraries, used by a program on this system from where the package is unpacked."""
    package = one(packages, "libkalfem-dev_*.deb")
    subprocess.run(["dpkg-deb", "-x", package, folder / "dev"], check=True)
    build = folder / "program"
    steps = [["cmake", "-S", PROJECT / "examples/cpp", "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={folder}/dev/usr", "-DCMAKE_CXX_FLAGS_RELEASE=-O0",
              "-DCMAKE_BUILD_TYPE=Release"], ["cmake", "--build", build, "--target", "run_case"],
             [build / "run_case", PROJECT / "examples/chain/chain.yaml", folder / "results"]]
    for step in steps:
        done = subprocess.run(step, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"FAILED: {step}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    require((folder / "results/summary.json").exists(), f"libkalfem-dev: a program that links it runs the chain; {package.stat().st_size / 1e6:.1f} MB")


def check_bill(packages):
    """What SPDX 2.3 asks of a document, and that nothing of it points nowhere."""
    bill = json.loads(one(packages, "*.spdx.json").read_text())
    require({"spdxVersion", "dataLicense", "SPDXID", "name", "documentNamespace", "creationInfo", "packages", "relationships"} == set(bill), "bill: its parts")
    require(bill["spdxVersion"] == "SPDX-2.3" and bill["dataLicense"] == "CC0-1.0" and bill["SPDXID"] == "SPDXRef-DOCUMENT", "bill: SPDX 2.3")
    ids = [bill["SPDXID"], *(package["SPDXID"] for package in bill["packages"])]
    require(len(ids) == len(set(ids)) and all(re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", each) for each in ids), f"bill: {len(ids) - 1} packages, each once")
    require(all({"SPDXID", "name", "downloadLocation"} <= set(package) for package in bill["packages"]), "bill: what each package must say")
    ends = {relation[end] for relation in bill["relationships"] for end in ("spdxElementId", "relatedSpdxElement")}
    require(ends == set(ids), "bill: relationships name what is there")
    names = {package["name"] for package in bill["packages"]}
    require({"kalfem", "libcholmod3", "libpagmo8", "libopenblas0-pthread", "libeigen3-dev", "three"} <= names, "bill: what is known to be linked")


def main():
    packages = pathlib.Path(sys.argv[1])
    if not packages.exists():
        skip(f"there is no {packages}: scripts/package make")
    if os.geteuid() != 0 or not shutil.which("debootstrap"):
        skip("a bare Debian needs root and debootstrap (scripts/setup --package)")
    check_bill(packages)
    with tempfile.TemporaryDirectory(prefix="kalfem-") as scratch:
        folder = pathlib.Path(scratch)
        bare = bare_root(folder / "bare", packages.parent.resolve() / "debian")
        check_archive(bare.copy("archive"), packages)
        check_debian_package(bare.copy("package"), packages)
        check_wheel(bare.copy("wheel"), packages)
        check_development_package(folder, packages)
        check_references(folder, packages)
    for file in sorted(packages.iterdir()):
        print(f"{file.stat().st_size / 1e6:8.2f} MB  {file.name}")


if __name__ == "__main__":
    main()
