#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# export --to paraview: VTK reads the .vti as the level's values where they stand in the world; the state is Python that says
# the scene; pvbatch, where ParaView is installed, draws the reference's picture.
. "$(dirname "$0")/lib.sh"
python_with vtkmodules,numpy
"$ISOSHADE" make marschner-lobb --size 21x25x13 --spacing 1x1x2.5 --rotate 1,2,3,40 -o v.nrrd -q >/dev/null
cat > unlit.scene.json <<'END'
{"schema": "isoshade.scene/1", "image": {"width": 48, "height": 36},
 "camera": {"projection": "perspective", "fit": true, "direction": [1, 2, -1.6], "up": [0, 0, 1], "margin": 0.9, "fov_y_deg": 30},
 "lights": [{"direction": [0, 0, 1], "space": "camera", "intensity": 1}],
 "shading": {"ambient": 0.8, "diffuse": 0, "specular": 0, "power": 1}, "background": [0.1, 0.2, 0.3], "step_voxels": 0.25,
 "tf": {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 2, "color_space": "linear", "table_size": 256,
        "points": [{"value": 0, "r": 0.05, "g": 0.15, "b": 0.6, "opacity": 0}, {"value": 0.3, "r": 0.05, "g": 0.3, "b": 0.8, "opacity": 0},
                   {"value": 0.5, "r": 0.9, "g": 0.6, "b": 0.2, "opacity": 0.5}, {"value": 1, "r": 0.6, "g": 0.05, "b": 0.05, "opacity": 0.05}]}}
END
sed 's/"diffuse": 0,/"diffuse": 0.2,/' unlit.scene.json > lit.scene.json
sed 's/"background"/"clip_planes": [{"normal": [1, 0, 0], "at": 0.5}], "background"/' unlit.scene.json > clipped.scene.json
export_to() { "$ISOSHADE" export "$1" --to paraview --scene "$2" -o "$3" -q; } # VOLUME SCENE OUTPUT

check a_folder_is_written export_to v.nrrd unlit.scene.json pv
has_files it_holds pv pv.vti pv.py
check a_lit_scene_too export_to v.nrrd lit.scene.json lit
check a_coarse_level_too "$ISOSHADE" export v.nrrd --to paraview --scene unlit.scene.json --level 1 --adapt -o coarse -q
# What a person calls the folder reaches no Python: quotes, a backslash, a letter of two bytes.
odd=$'odd "\'; import os \\\xc3\xa9'
check an_odd_name export_to v.nrrd unlit.scene.json "$odd"
check it_is_its_own_again export_to v.nrrd unlit.scene.json "$odd"
has_files an_odd_name_is_made_plain "$odd" odd_____import_os____.vti odd_____import_os____.py

cat > judge.py <<'END'
import ast, math, sys
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

def nrrd(path):
    head, data = open(path, "rb").read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines() if ": " in line and line[0] != "#")
    rows = np.array([[float(x) for x in row.split(",")] for row in fields["space directions"].strip("()").split(") (")])
    origin = np.array([float(x) for x in fields["space origin"].strip("()").split(",")])
    return np.frombuffer(data, "<u2").reshape([int(n) for n in fields["sizes"].split()][::-1]), rows.T, origin

def vti(path):
    reader = vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()

def state(path):
    tree = ast.parse(open(path).read())  # no statement but those of the state may be in it
    scene = [ast.literal_eval(node.value) for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "SCENE"]
    assert len(scene) == 1
    return scene[0], [type(node).__name__ for node in tree.body]

def case(name, good, said=""):
    print(f"{'ok' if good else 'not ok'} {name}" + ("" if good else f": {said}"))

values, axes, first = nrrd("v.nrrd")
image = vti("pv/pv.vti")
cells = vtk_to_numpy(image.GetCellData().GetArray("value"))
case("values_are_those_of_the_volume", np.array_equal(cells.reshape(values.shape), values.astype("f4")))
case("there_are_no_values_at_points", image.GetPointData().GetNumberOfArrays() == 0)
worst = 0
for at in ((0, 0, 0), (20, 0, 0), (3, 24, 7), (20, 24, 12)):
    center = [0, 0, 0]
    image.TransformContinuousIndexToPhysicalPoint([i + 0.5 for i in at], center)
    worst = max(worst, abs(np.array(center) - (axes @ at + first)).max())
case("voxels_stand_where_they_are", worst < 1e-9, worst)
coarse = vti("coarse/coarse.vti")
case("a_coarse_level_has_its_own_size", coarse.GetDimensions() == (12, 14, 8), coarse.GetDimensions())
case("and_the_mean_of_eight", abs(vtk_to_numpy(coarse.GetCellData().GetArray(0))[0] - values[:2, :2, :2].mean()) < 0.01)

scene, statements = state("pv/pv.py")
tf, camera = scene["tf"], scene["camera"]
spacing = (1 * 1 * 2.5) ** (1 / 3)
case("the_unit_is_that_of_the_transfer_function", abs(tf["unit_mm"] - 2 * spacing) < 1e-6, tf["unit_mm"])
low, high = float(values.min()), float(values.max())
points = np.array([[0, 0], [0.3, 0], [0.5, 0.5], [1, 0.05]])
table = np.linspace(0, 1, 256)
extinction = -np.log1p(-np.interp(table, points[:, 0], points[:, 1]))  # for one unit
opacities = np.array(tf["opacities"])
wanted = -np.expm1(-np.interp((opacities[:, 0] - low) / (high - low), table, extinction))
case("opacities_are_those_of_the_table", abs(opacities[:, 1] - wanted).max() < 1e-6, abs(opacities[:, 1] - wanted).max())
# Straight lines between the points, as ParaView draws them, against the curve of extinctions that are linear.
fine = np.linspace(low, high, 50001)
curve = -np.expm1(-np.interp((fine - low) / (high - low), table, extinction))
off = abs(np.interp(fine, opacities[:, 0], opacities[:, 1]) - curve).max()
case("straight_lines_between_them_follow_the_curve", off < 0.02 / 255, off)
colors = np.array(tf["colors"])
case("colors_are_linear_and_ambient", np.allclose(colors[[0, -1], 1:], [[0.04, 0.12, 0.48], [0.48, 0.04, 0.04]], atol=1e-6), colors[[0, -1]])
case("the_view_is_the_picture", (scene["width"], scene["height"]) == (48, 36) and scene["background"] == [0.1, 0.2, 0.3])
case("the_camera_is_the_scenes", np.allclose(camera["forward"], np.array([1, 2, -1.6]) / np.linalg.norm([1, 2, -1.6]))
     and abs(camera["half_height"] - math.tan(math.radians(15))) < 1e-8 and camera["projection"] == "perspective")
case("no_light_no_shading", scene["shade"] == 0 and state("lit/lit.py")[0]["shade"] == 1)
odd, others = state(sys.argv[1])
case("an_odd_name_adds_no_statement", others == statements and odd["name"] == "odd_____import_os____", odd["name"])
END
"$python" judge.py "$odd"/*.py >cases 2>err || not_ok the_files_are_judged "$(tail -n 1 err)"
while IFS= read -r line; do
    [[ $line == ok* ]] && echo "$line" || not_ok "$(sed 's/^not ok \([a-z_]*\).*/\1/' <<<"$line")" "${line#*: }"
done <cases
holds all_were_judged "$(grep -c ^ok cases) == 13"

# ---- what it cannot say is refused by name, and nothing is left ----
refuse clip_planes 2 "clip planes" export_to v.nrrd clipped.scene.json x
printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspace: right-anterior-superior\nspace directions: (1,0,0) (0.5,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\nabcdefgh' > sheared.nrrd
refuse a_sheared_grid 2 "a sheared grid" export_to sheared.nrrd unlit.scene.json x
refuse a_region_of_interest 2 "--roi" "$ISOSHADE" export v.nrrd --to paraview --scene unlit.scene.json --level 1 --roi 2,2,2,9,9,9 -q -o x
refuse a_step 2 "--step" "$ISOSHADE" export v.nrrd --to paraview --scene unlit.scene.json --step 1 -q -o x
mkdir foreign && touch foreign/mine
refuse a_folder_of_someone 3 "foreign" export_to v.nrrd unlit.scene.json foreign
check it_stays test -e foreign/mine

# ---- the picture ----
if command -v pvbatch >/dev/null && command -v xvfb-run >/dev/null; then
    "$ISOSHADE" render v.nrrd --scene unlit.scene.json --with reference -o ref.exr -q >/dev/null
    check pvbatch_runs_the_state xvfb-run -a pvbatch pv/pv.py
    rmse=$("$python" - "$top/tests/peers" <<'END'
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
import pictures
exr = pictures.read_exr("ref.exr")
print(np.sqrt(np.mean((pictures.read_png("pv/pv.png")[..., :3] - np.dstack([exr[c] for c in "RGB"])) ** 2)))
END
    )
    # 8 bits, and VTK's whole steps at the faces: 0.002; a box from center to center is 0.03 off
    holds its_picture_is_the_references "${rmse:-1} < 0.004"
else
    skip its_picture_is_the_references "ParaView (Debian package python3-paraview, beside xvfb) is not installed; it conflicts with python3-vtk9"
fi
exit $failed
