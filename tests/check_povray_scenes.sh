#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What a person does with an exported POV-Ray folder: includes the volume in a scene with lamps and a floor, edits the color
# map, sets lights, makes it quicker. Closed forms where there are some.
. "$(dirname "$0")/lib.sh"
export HOME=$dir # no settings of a user
shading='"shading": {"ambient": 0.2, "diffuse": 0.5, "specular": 0.3, "power": 8}'
# scene NAME LIGHT SHADING RED: a view from +z, two points of unequal opacity
scene() {
    cat >"$1.scene.json" <<JSON
{"schema": "isoshade.scene/1", "image": {"width": 12, "height": 12}, $3,
 "camera": {"projection": "perspective", "fit": true, "direction": [0.1, 0.2, -1], "up": [0, 1, 0], "margin": 1.0, "fov_y_deg": 30},
 "lights": [{"direction": $2, "space": "world", "intensity": 0.9}], "background": [0.1, 0.2, 0.3], "step_voxels": 0.5,
 "tf": {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_mm": 4, "color_space": "linear", "table_size": 256, "points": [
  {"value": 0, "r": $4, "g": 0.4, "b": 0.2, "opacity": 0}, {"value": 0.5, "r": $4, "g": 0.4, "b": 0.2, "opacity": 0.1},
  {"value": 1, "r": 0.1, "g": 0.6, "b": 0.9, "opacity": 0.6}]}}
JSON
}
scene a "[0, 0.3, 1]" "$shading" 0.8
scene b "[1, 0.3, 0.2]" "$shading" 0.8
scene red "[0, 0.3, 1]" "$shading" 0.3
"$ISOSHADE" make noise --size 10x9x11 --spacing 1x1x1.5 -q -o v.nrrd
for s in a b red; do "$ISOSHADE" export v.nrrd --to povray --scene $s.scene.json -q -o $s >out || not_ok export "$(cat out)"; done

# draw FOLDER FILE NAME OPTIONS: a picture of linear light, NAME.ppm in the folder above
draw() { (cd "$1" && povray "$2" Output_File_Type=P Bits_Per_Color=16 File_Gamma=1.0 Display=Off Output_File_Name="../$3.ppm" "${@:4}" >log 2>&1) || not_ok "draw_$3" "$(grep -i error "$1/log")"; }
cat >ppm.py <<'PY'
import re, sys
def read(name):
    data = open(name + ".ppm", "rb").read()
    width, height = re.match(rb"P6\s+(?:#[^\n]*\n)*(\d+)\s+(\d+)\s", data).groups()
    size = int(width) * int(height)
    raw = data[-6 * size:]
    return [int.from_bytes(raw[i:i + 2], "big") / 65535 for i in range(0, len(raw), 2)]
a, b = read(sys.argv[1]), read(sys.argv[2]) if sys.argv[2].isidentifier() else [float(v) for v in sys.argv[2].split(",")]
most = max(abs(x - y) for x, y in zip(a, b)) if len(a) == len(b) else 9
print(f"{sys.argv[1]} differs by {most:.3g}: {a[:3]}")
sys.exit(most > float(sys.argv[3]))
PY
alike() { python3 ppm.py "$1" "$2" "${3:-2e-5}"; }

# ---- the folder as it is, and by the command line ----
draw a a.ini a
draw b b.ini b
notice two_lights_show alike a b 1e-2
check the_ini_has_the_samples grep -q 'Declare=Iso_Intervals=[0-9]' a/a.ini
check of_the_scenes_step grep -q 'A sample every 0.[0-9]* voxels' a/a.ini
"$ISOSHADE" export v.nrrd --to povray --scene a.scene.json --step 0.125 -q -o fine >out
draw fine fine.ini fine
notice a_step_of_ones_own alike fine a 2e-5
draw a a.ini quick Declare=Iso_Intervals=4 Declare=Iso_Planes=0
notice the_command_line_comes_last alike quick a 1e-3

# ---- the color map ----
check its_points_are_there grep -q 'Iso_At (.*) rgbt <0.8, 0.4, 0.2, 0.9>' a/a_tf.inc
check as_exported_it_is_the_exact_table sh -c '! grep -q "was edited" a/log'
sed -i 's/rgbt <0.8,/rgbt <0.3,/' a/a_tf.inc
draw a a.ini edited
draw red red.ini red
check an_edited_map_is_taken alike edited red
check and_said grep -q 'was edited' a/log
notice it_is_another_picture alike edited a 1e-2
sed -i 's/rgbt <0.3,/rgbt <0.8,/' a/a_tf.inc

# ---- lights and camera of one's own scene ----
printf '#version 3.7;\n#declare Iso_Lights = array[1] { <2, 0.6, 0.4, 0.9> };\n#include "a.pov"\n' >a/lit.pov
draw a a.ini lit Input_File_Name=lit.pov
check lights_can_be_set alike lit b
place=$(sed -n 's/^ *location *\(<.*>\).*/\1/p' a/a.pov)
printf '#version 3.7;\n#declare Iso_Viewer = %s;\n#include "a.pov"\n' "$place" >a/viewer.pov
draw a a.ini viewer Input_File_Name=viewer.pov
check the_viewer_where_it_was alike viewer a
printf '#version 3.7;\n#declare Iso_Viewer = <30000, 0, 0>;\n#include "a.pov"\n' >a/elsewhere.pov
draw a a.ini elsewhere Input_File_Name=elsewhere.pov
notice highlights_follow_the_viewer alike elsewhere a 1e-3

# ---- a slab with half the light behind it, a lamp above it, a white floor below ----
python3 -c 'open("slab.nrrd", "wb").write(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nspacings: 1 1 1\nencoding: raw\n\n" + bytes([100]) * 512)'
cat >slab.scene.json <<'JSON'
{"schema": "isoshade.scene/1", "image": {"width": 8, "height": 8},
 "camera": {"projection": "orthographic", "fit": true, "direction": [0, 0, -1], "up": [0, 1, 0], "margin": 1.0},
 "lights": [{"direction": [0, 0, 1], "space": "world", "intensity": 1}],
 "shading": {"ambient": 1, "diffuse": 0, "specular": 0, "power": 8}, "background": [0, 0, 0], "step_voxels": 0.25,
 "tf": {"schema": "isoshade.tf/1", "range": [0, 200], "unit_distance_mm": 8, "color_space": "linear", "table_size": 3,
  "points": [{"value": 0, "r": 0.8, "g": 0.4, "b": 0.2, "opacity": 0.5}, {"value": 200, "r": 0.8, "g": 0.4, "b": 0.2, "opacity": 0.5}]}}
JSON
"$ISOSHADE" export slab.nrrd --to povray --scene slab.scene.json -q -o slab >out
cat >slab/own.pov <<'POV'
#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 20 }
#declare Iso_Intervals = 100;
#declare Iso_Scale = 0.001;
#include "slab.inc"
camera { orthographic location <0, 0, 50> direction -z right x*0.1 up y*0.1 }
light_source { <0, 0, 1e5> rgb 1 parallel point_at 0 }
object { Iso_Volume transform { Iso_To_World } scale Iso_Scale }
#ifdef (Floor) plane { z, -20 pigment { rgb Floor } finish { ambient 0 diffuse 1 } } #end
#declare Around = sphere { 0, 100 pigment { rgb 0 } finish { ambient 0 diffuse 0 } }
#ifdef (Hollow) #if (Hollow) Iso_Around_Volume (Around) #else object { Around } #end #end
#if (version != 3.7) #error "the version did not come back" #end
POV
own() { draw slab own.pov "$1" +W1 +H1 "${@:2}"; }
# color * (1 - T) of the slab, and T of what the floor sends back, which the lamp reaches by T: T = 1/2
own shadow Declare=Floor=0.5
check a_shadow_on_the_floor alike shadow 0.525,0.325,0.225
# Emission alone, color * (1 - T), in a black sphere; a solid one hides it.
own around Declare=Hollow=1
check it_is_seen_in_a_hollow_sphere alike around 0.4,0.2,0.1
own solid Declare=Hollow=0
check and_not_in_a_solid_one alike solid 0,0,0
own unshadowed Declare=Floor=0.5 Declare=Iso_Shadows=0
check no_shadow_when_it_is_off alike unshadowed 0.65,0.45,0.35
# color * sigma * integral of exp(-2 sigma t): color / 2 * (1 - T^2), by a rule of second order
own scattered Declare=Iso_Scattering=1
check lamps_scatter_in_it_with_its_own_shadow alike scattered 0.3,0.15,0.075
own dark Declare=Iso_Scattering=1 Declare=Iso_Emission=0
check and_nothing_else alike dark 0,0,0
exit $failed
