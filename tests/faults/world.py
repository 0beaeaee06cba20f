# SPDX-License-Identifier: MIT
"""Commands of isoshade in folders of their own, what they leave there, and whether that is right. faults.py lets their
calls fail, kills.py ends them, ../pipelines.py chains them."""
import hashlib
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
ISOSHADE = os.path.realpath(os.environ.get("ISOSHADE", f"{TOP}/isoshade"))
SCENE, TF = f"{TOP}/refscenes/shells.scene.json", f"{TOP}/refscenes/shells.tf.json"
PROGRESS = re.compile(r"^[a-z ]+: .* [0-9]+ %(, about .* left)?$|^[a-z ]+: ended after ")
# How long it took stands in what commands print, and may be the same in two runs by chance.
DURATION = re.compile(r"(?<![0-9a-z.])[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)? (s|ms)\b")
# An output is a picture, a report ... of one run: what tells when, and how long, differs.
UUID = re.compile(rb"[0-9a-fA-F]{8}(-[0-9a-fA-F]{4}){3}-[0-9a-fA-F]{12}") # OpenVDB 13 writes capitals
# Of a chart also how many frames were timed, and the numbers of the points on its front of time.
PASSING = re.compile(r"second|time|date|_ms$|per_s|speed|version_of|host|\.processor$|^\.work\.|\.cases\[[0-9]+\]\.(frames|number)$", re.I)

# name: (fixtures, arguments); {S}, {T}: scene and transfer function. Fixtures are made once by the commands of their names.
small = "--size 8"
FIXTURES = {
    "s.nrrd": "make shells --size 12x10x11 -o s.nrrd -q",
    "s.iso": "build s.nrrd -o s.iso --levels 2 -q",
    "r": "validate s.nrrd --scene {S} --with reference,gl --quick --levels 2 --size 12 --anyway -o r -q",
    "b.json": "report diff b.json r --accept -q",
    "p.json": "plan s.nrrd --scene {S} --size 16 --error 0.05 -o p.json -q",
}
# Volumes of other formats, which are read within isoshade or by a program of its own: of tests/fuzz/seeds.
SEEDS = {"angstrom.cube": "cube", "phantom.gipl.gz": "gipl", "unit.mha": "metaimage", "multi.dcm": "dicom",
         "phantom.mrc": "mrc", "nibabel.nii.gz": "nifti", "scaled.nii": "nifti", "gzip.nrrd": "nrrd", "text.nrrd": "nrrd",
         "imagej.tif": "tiff", "v.vdb": "vdb", "zlib.vti": "vti", "binary.vtk": "vtk", "text.vtk": "vtk",
         "phantom.xsf": "xsf"}
WRITTEN = {"list.nhdr": b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\ndata file: LIST 2\na.raw\nb.raw\n",
           "a.raw": b"\1\2\3\4", "b.raw": b"\5\6\7\10"}
COMMANDS = {
    "make": ("", "make shells --size 12x10x11 -o o.nrrd -q"),
    "make gzip": ("", "make sphere --size 12 --gzip -o o.nrrd -q"),
    "info": ("s.nrrd", "info s.nrrd --json -q"),
    "info pyramid": ("s.iso", "info s.iso --verify -q"),
    "build": ("s.nrrd", "build s.nrrd -o o.iso --levels 2 -q"),
    "build again": ("s.nrrd s.iso", "build s.nrrd -o s.iso --levels 3 -q"),
    "build --resume": ("s.nrrd .o.iso.partial", "build s.nrrd -o o.iso --levels 2 --resume -q"),
    "render reference": ("s.iso", "render s.iso --scene {S} --with reference --step 0.5 --size 8 -o o.exr --png o.png -q"),
    "compare": ("s.exr", "compare s.exr s.exr --json -q"),
    "tf adapt": ("s.iso", "tf adapt s.iso --tf {T} --level 1 -o o.tf.json -q"),
    "tf suggest": ("s.nrrd", "tf suggest s.nrrd -o o.tf.json -q"),
    "tf convert": ("", "tf convert {T} o.csv"),
    "tf show": ("", "tf show {T} -o o.svg -q"),
    "palette": ("s.nrrd", "palette s.nrrd --entries 4 -o o.csv -q"),
    "plan": ("s.nrrd", "plan s.nrrd --scene {S} --size 16 --error 0.05 -o o.json -q"),
    "export vdb": ("s.iso", "export s.iso --scene {S} --to vdb -o o.vdb -q"),
    "export nanovdb": ("s.iso", "export s.iso --scene {S} --to nanovdb -o o.nvdb -q"),
    "export povray": ("s.iso", "export s.iso --scene {S} --to povray -o o -q"),
    "export pbrt": ("s.iso", "export s.iso --scene {S} --to pbrt -o o -q"),
    "export paraview": ("s.iso", "export s.iso --scene {S} --to paraview -o o -q"),
    "view": ("s.iso", "view s.iso --scene {S} --size 16 -o o.html -q"),
    "report diff --worse": ("r b.json", "report diff b.json r --worse -q"),
    "report diff --accept": ("r", "report diff b.json r --accept -q"),
    "report diff": ("r", "report diff r r -o o --summary-md o.md -q"),
    "figure report": ("r", "figure r -o o -q"),
    "atlas": ("", "atlas --case code-poles -o o -q"),
    "render cpu": ("s.iso", "render s.iso --scene {S} --with cpu --size 8 -o o.exr -q"),
    "render external": ("s.iso s.exr r.json", "render s.iso --scene {S} --with copier --renderers r.json --size 8 -o o.exr -q"),
    "render gl": ("s.iso", "render s.iso --scene {S} --with gl --size 8 -o o.exr -q"),
    "chart": ("s.nrrd", "chart s.nrrd --scene {S} --budget 0 --size 8 --levels 1 --with gl --steps 1 --codes fit --filters moments "
              "--estimators central --plans none -o o -q"),
    "validate": ("s.nrrd", "validate s.nrrd --scene {S} --with reference,gl --quick --levels 1 --size 12 -o o -q"),
    "render povray": ("s.iso", "render s.iso --scene {S} --with povray --intervals 10 --size 8 -o o.exr -q"),
    "render cycles": ("s.iso", "render s.iso --scene {S} --with cycles --size 8 -o o.exr -q"),
    "export blender": ("s.iso", "export s.iso --scene {S} --to blender -o o.blend -q"),
    "figure levels": ("s.nrrd", "figure s.nrrd --scene {S} --kind levels --levels 2 --width 40 --dpi 100 -o o -q"),
    "scenes": ("s.nrrd", "scenes s.nrrd --tf angiography --view front --size 32 -o o.png -q"),
}
COMMANDS.update({f"info {name}": (name, f"info {name} --json -q") for name in SEEDS})
COMMANDS["info list.nhdr"] = ("list.nhdr a.raw b.raw", "info list.nhdr --json -q")
LARGE = {
    "make": ("", "make shells --size 80 -o o.nrrd -q"),
    "build": ("l.nrrd", "build l.nrrd -o o.iso --levels 2 -q"),
    "info": ("l.nrrd", "info l.nrrd --json -q"),
    "info pyramid": ("l.iso", "info l.iso --verify -q"),
    "render reference": ("l.iso", "render l.iso --scene {S} --with reference --step 2 --size 8 -o o.exr -q"),
    "render gl": ("l.iso", "render l.iso --scene {S} --with gl --step 2 --size 8 -o o.exr -q"),
    "export vdb": ("l.iso", "export l.iso --scene {S} --to vdb -o o.vdb -q"),
    "export povray": ("l.iso", "export l.iso --scene {S} --to povray -o o -q"),
    "tf adapt": ("l.iso", "tf adapt l.iso --tf {T} --level 1 -o o.tf.json -q"),
    "view": ("l.iso", "view l.iso --scene {S} --size 16 -o o.html -q"),
    "plan": ("l.nrrd", "plan l.nrrd --scene {S} --size 16 --error 0.05 -o o.json -q"),
}
MADE = {"l.nrrd": "make shells --size 80 -o l.nrrd -q", "l.iso": "build l.nrrd -o l.iso --levels 2 -q",
        "s.exr": "render s.iso --scene {S} --with reference --step 0.5 --size 8 -o s.exr -q"}


def words(text):
    return [ISOSHADE] + text.format(S=SCENE, T=TF).split()


def environment(temporary, home, **more):
    """Other programs find their own Python: not that of a virtual environment."""
    env = {k: v for k, v in os.environ.items() if not k.startswith(("FAULTS_", "LD_PRELOAD", "LC_"))}
    env["PATH"] = ":".join(p for p in env["PATH"].split(":") if "pyenv" not in p and "venv" not in p)
    env.update(OMP_NUM_THREADS="1", TMPDIR=temporary, HOME=home, LC_ALL="C", **more)
    return env


def listing(folder):
    """Name -> sha256 of its bytes; of a folder 'folder', of a link its target."""
    found = {}
    for root, folders, files in os.walk(folder):
        for name in folders + files:
            path = os.path.join(root, name)
            key = os.path.relpath(path, folder)
            if os.path.islink(path):
                found[key] = "link " + os.readlink(path)
            elif os.path.isdir(path):
                found[key] = "folder"
            else:
                with open(path, "rb") as file:
                    data = file.read()
                if "_joint" in name: # what a pyramid's folder keeps for the next run, or does not
                    continue
                if name == ".isoshade-files":
                    data = b"\n".join(line for line in data.split(b"\n") if b"_joint" not in line)
                if name.endswith(".vdb"): # OpenVDB draws a number for each file
                    data = UUID.sub(b"", data, 1)
                found[key] = hashlib.sha256(data).hexdigest()
    return found


def leaves(value, at=""):
    if isinstance(value, dict):
        for k, v in value.items():
            yield from leaves(v, f"{at}.{k}")
    elif isinstance(value, list):
        for i, v in enumerate(value):
            yield from leaves(v, f"{at}[{i}]")
    else:
        yield at, value


def content(path):
    """What a file says, in parts that can be compared: the leaves of a JSON, else the words between numbers. What is packed
    has no words."""
    if path.endswith((".pdf", ".png")):
        return {}
    with open(path, "rb") as file:
        # A report holds its command, how many pictures were there to go on from, and which renderer drew how many, the first
        # to draw first.
        data = re.sub(rb' --resume|,"pictures_taken":[0-9]+|"renderers":\{("\w+":\{[^{}]*\},?)+\}', b"", file.read())
    if path.endswith((".json", ".jsonl")):
        try:
            if path.endswith(".json"):
                return dict(leaves(json.loads(data)))
            lines = [json.loads(line) for line in data.splitlines()] # of a chart, which measures what is fast first
            return dict(leaves({f"{x.get('scene')}, {x.get('setting')}": x for x in lines}))
        except ValueError:
            return {"": data}
    processor = re.search(rb'"processor":"([^"]+)"', data) # a report's, which /proc may not have told
    if processor:
        data = data.replace(processor[1], b"unknown")
    return {"": re.sub(rb"[0-9]+(\.[0-9]*)?([eE][-+]?[0-9]+)?", b"#", data)}


def says_what_is_missing(report):
    """A whole report, of which not all could be compared."""
    try:
        with open(f"{report}/report.json") as file:
            text = file.read()
        json.loads(text)
    except (OSError, ValueError):
        return False
    return os.path.exists(f"{report}/index.html") and "missing" in text


def without_durations(text):
    return DURATION.sub(r"# \3", text)


def wait_for_another_second():
    """What is dated, a PDF in a manifest by its checksum too, then differs between two runs."""
    time.sleep(1 - time.time() % 1)


class World:
    """A folder with fixtures, copies of it to run in, and what each command leaves when nothing disturbs it."""

    def __init__(self):
        self.base = tempfile.mkdtemp(prefix="faults-")
        self.fixtures = f"{self.base}/fixtures"
        self.home = f"{self.base}/home"
        os.makedirs(self.fixtures)
        os.makedirs(self.home)
        self.right = {}
        self.number = 0

    def close(self):
        shutil.rmtree(self.base, ignore_errors=True)

    def fixture(self, name):
        path = f"{self.fixtures}/{name}"
        if os.path.exists(path):
            return path
        if name == ".o.iso.partial":
            self.partial(path)
            return path
        if name in SEEDS:
            shutil.copy(f"{TOP}/tests/fuzz/seeds/{SEEDS[name]}/{name}", path)
            return path
        if name in WRITTEN:
            with open(path, "wb") as file:
                file.write(WRITTEN[name])
            return path
        if name == "r.json":
            with open(path, "w") as file:
                json.dump(self.renderer(), file)
            return path
        for needed in ("s.nrrd", "s.iso", "r", "l.nrrd"):
            if needed != name and needed in (FIXTURES.get(name) or MADE[name]).split():
                self.fixture(needed)
        subprocess.run(words(FIXTURES.get(name) or MADE[name]), cwd=self.fixtures, check=True, stdout=subprocess.DEVNULL,
                       env=environment(self.base, self.home))
        return path

    def renderer(self):
        """A program that hands over a picture that is there."""
        return {"schema": "isoshade.renderers/1", "renderers": [
            {"name": "copier", "command": ["sh", "-c", f"cp {self.fixture('s.exr')} frame0.exr"], "tier": "samples",
             "can": ["lights", "orthographic"]}]}

    def partial(self, path):
        """A build that was killed in the middle: the first of its folders that has something in it."""
        self.fixture("s.nrrd")
        for step in range(1, 200):
            shutil.rmtree(path, ignore_errors=True)
            subprocess.run(words("build s.nrrd -o o.iso --levels 2 -q"), cwd=self.fixtures, stdout=subprocess.DEVNULL,
                           env=environment(self.base, self.home, FAULTS_STATE=f"{self.base}/partial", LD_PRELOAD=shim(),
                                           FAULTS_KIND="rename", FAULTS_HOW="-9", FAULTS_AT=str(step)))
            os.remove(f"{self.base}/partial")
            if os.path.isdir(path):
                return
            shutil.rmtree(f"{self.fixtures}/o.iso", ignore_errors=True)
        raise SystemExit("faults: no killed build leaves a folder to resume in")

    def folder(self, command):
        """A fresh folder with the fixtures of a command, and an empty one for temporaries."""
        self.number += 1
        here = f"{self.base}/{self.number}"
        os.makedirs(f"{here}/w")
        os.makedirs(f"{here}/t")
        for name in COMMANDS[command][0].split():
            path = self.fixture(name)
            if os.path.isdir(path):
                shutil.copytree(path, f"{here}/w/{name}")
            else:
                shutil.copy(path, f"{here}/w/{name}")
        return here

    def run(self, command, here, limit=120, arguments=None, **more):
        """Runs it; (exit code or -signal, lines of stdout, lines of stderr)."""
        child = subprocess.Popen(words(arguments or COMMANDS[command][1]), cwd=f"{here}/w", stdin=subprocess.DEVNULL,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
                                 env=environment(f"{here}/t", self.home, **more))
        try:
            out, err = child.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
            child.communicate()
            return "hangs", [], []
        said = [line for line in err.decode(errors="replace").splitlines() if line and not PROGRESS.match(line) and ": warning: " not in line]
        return child.returncode, without_durations(out.decode(errors="replace")).splitlines(), said

    def learn(self, command):
        """What is right: runs it twice; what differs between the two is compared by its words alone."""
        if command in self.right:
            return self.right[command]
        runs = []
        for _ in range(2):
            wait_for_another_second()
            here = self.folder(command)
            before = listing(f"{here}/w")
            code, out, err = self.run(command, here)
            if code != 0:
                raise SystemExit(f"faults: {command} fails undisturbed: {code} {err}")
            if os.listdir(f"{here}/t"):
                raise SystemExit(f"faults: {command} leaves {os.listdir(f'{here}/t')} undisturbed")
            runs.append((here, before, listing(f"{here}/w"), out, err))
        (a, before, files, out, err), (b, _, again, out_b, _) = runs
        loose = {}
        for name in files:
            if files[name] != again.get(name):
                x, y = content(f"{a}/w/{name}"), content(f"{b}/w/{name}")
                loose[name] = {k: v for k, v in x.items() if y.get(k) == v and not PASSING.search(k)}
        self.right[command] = {"before": before, "files": files, "loose": loose, "out": out if out == out_b else None,
                               "err": err, "left": None}
        for here, *_ in runs:
            shutil.rmtree(here)
        return self.right[command]

    def is_right(self, command, here, stale=()):
        """None: the folder holds what it has to; else what is wrong. stale: temporaries of an earlier run, which may be there."""
        right = self.right[command]
        files = {n: v for n, v in listing(f"{here}/w").items() if n not in stale or n in right["files"]}
        for name in sorted(set(files) | set(right["files"])):
            if name not in files:
                return f"{name} is missing"
            if name not in right["files"]:
                return f"{name} is left over"
            if files[name] == right["files"][name]:
                continue
            if name not in right["loose"]:
                return f"{name} has other bytes"
            there = content(f"{here}/w/{name}")
            for key, value in right["loose"][name].items():
                if there.get(key) != value:
                    return f"{name} says something else{' at ' + key if key else ''}"
        return None

    def is_untouched(self, command, here, code=None):
        """Nothing is lost, changed or left over. Of several outputs those that are finished may be there, and right; of
        validate what --resume goes on from, and where a renderer is missing (7) the report that says so."""
        before, files, right = self.right[command]["before"], listing(f"{here}/w"), self.right[command]["files"]
        kept = {"o.work"} | ({"o"} if code == 7 and says_what_is_missing(f"{here}/w/o") else set())
        for name in sorted(set(files) | set(before)):
            if command == "validate" and name not in before and name.split("/")[0] in kept:
                continue
            if command == "build --resume" and name.split("/")[0] == ".o.iso.partial" and ".o.iso.partial" in files:
                continue # faults.py has another run go on with it
            if files.get(name) not in (before.get(name), right.get(name, "")):
                return f"{name} is {'lost' if name not in files else 'left over' if name not in before else 'changed'}"
        return None


def shim():
    """The library of shim.c, built when it is not there."""
    path = f"{TOP}/build/faults/shim.so"
    source = f"{HERE}/shim.c"
    if not os.path.exists(path) or os.path.getmtime(path) < os.path.getmtime(source):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        new = f"{path}.{os.getpid()}"
        subprocess.run(["gcc", "-std=gnu11", "-O1", "-g", "-Wall", "-Wextra", "-shared", "-fPIC", "-o", new, source],
                       check=True)
        os.rename(new, path)
    return path


KINDS = "memory read write open rename sync make look close start".split()
FRAMES, MODULES, SITES = 16, 256, 1 << 15


class State:
    """What the shim counted."""

    def __init__(self, path):
        data = open(path, "rb").read()
        self.calls = dict(zip(KINDS, struct.unpack_from("<10Q", data, 0)))
        self.failed = struct.unpack_from("<Q", data, 80)[0] != 0
        count = struct.unpack_from("<Q", data, 216)[0]
        self.modules = [data[232 + 64 * i:296 + 64 * i].split(b"\0")[0].decode() for i in range(min(count, MODULES))]
        self.frames = self.take(data, 88)
        self.sites = []
        at = 232 + 64 * MODULES
        for i in range(SITES):
            number, kind, first, calls = struct.unpack_from("<4Q", data, at + 160 * i)
            if number:
                self.sites.append((KINDS[kind], first, calls, self.take(data, at + 160 * i + 32)))
        self.sites.sort(key=lambda s: (KINDS.index(s[0]), s[1]))

    def take(self, data, at):
        modules, offsets = struct.unpack_from("<16I", data, at), struct.unpack_from("<16I", data, at + 64)
        return tuple((self.modules[m], o) for m, o in zip(modules, offsets) if o)
