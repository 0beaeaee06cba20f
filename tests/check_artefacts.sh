#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What is handed over: an exported POV-Ray folder and a .blend are moved away, opened by the programs themselves as a
# person would, and their pictures compared with the reference's, background and all. Planted faults are seen there.
. "$(dirname "$0")/lib.sh"
export HOME=$dir # of the programs, too: no settings of a user

# Smooth, so that steps show nothing of themselves in 8 bits; a background of three unequal colors; a highlight.
cat >s.scene.json <<'JSON'
{"schema": "isoshade.scene/1", "image": {"width": 40, "height": 32},
 "camera": {"projection": "perspective", "fit": true, "direction": [1, 2, -1], "up": [0, 0, 1], "margin": 1.1, "fov_y_deg": 25},
 "lights": [{"direction": [-0.3, 0.5, 1], "space": "camera", "intensity": 1}],
 "shading": {"ambient": 0.2, "diffuse": 0.6, "specular": 0.3, "power": 8},
 "background": [0.1, 0.5, 0.25], "step_voxels": 0.25,
 "agreement": {"tier": "convergence", "tf": "smooth", "why": "opacity rises slowly"},
 "tf": {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 1, "color_space": "linear", "table_size": 256,
  "points": [{"value": 0, "r": 0.9, "g": 0.3, "b": 0.1, "opacity": 0}, {"value": 1, "r": 0.2, "g": 0.5, "b": 0.9, "opacity": 0.2}]}}
JSON
"$ISOSHADE" make noise --size 18x20x16 --spacing 1x1x1.5 -q -o v.nrrd
"$ISOSHADE" make noise --size 18x20x16 --spacing 1x1x1.5 --seed 2 -q -o other.nrrd
"$ISOSHADE" render v.nrrd --scene s.scene.json --level 1 --with reference --quadrature povray --intervals 255 -q -o same.png >out
"$ISOSHADE" render v.nrrd --scene s.scene.json --level 1 --with reference -q -o reference.png >out

# 8 bits a channel: values that stand at a rounding's edge go to either side, by one step, which at the bright end is 0.009
# in linear light. POV-Ray takes the reference's samples, from directions and values in files of 16 bits. Cycles has the
# scene's step, which leaves less than that step of 8 bits; and Blender dithers pictures of 8 bits, by half a step more.
alike() { "$ISOSHADE" compare "$1" "$2" --max-abs "${3:-0.0095}" --max-rmse "${4:-0.0015}" -q; }

# export_to TARGET NAME SCENE VOLUME: into here/, which is moved to elsewhere/
export_to() {
    rm -rf here elsewhere && mkdir here
    "$ISOSHADE" export "$4" --to "$1" --scene "$3" --level 1 -q -o "here/$2" >out || echo "not exported: $*"
    [ -z "${before_moving:-}" ] || $before_moving
    mv here elsewhere
}
# As doc/guide/povray.md says: "povray NAME.ini" where the folder lies.
show_povray() { (cd elsewhere/scene && rm -f scene.png && povray scene.ini >log 2>&1 && test -s scene.png); }
povray_is_right() { show_povray && alike same.png elsewhere/scene/scene.png; }
# As a person without a window, with the settings of the agreement: a picture for people.
show_blender() { blender -b elsewhere/s.blend --python-text "isoshade agreement" -F PNG -f 1 >log 2>&1 && test -s elsewhere/s_0001.png; }
blend_is_right() { show_blender && alike reference.png elsewhere/s_0001.png 0.0143 0.003; }

export_to povray scene s.scene.json v.nrrd
check a_folder_of_povray_shows_what_the_reference_shows povray_is_right
check also_as_the_converged_reference_has_it alike reference.png elsewhere/scene/scene.png
"$ISOSHADE" render other.nrrd --scene s.scene.json --level 1 --with gl -q -o other.png >out
notice another_picture_is_not_alike alike other.png elsewhere/scene/scene.png
sed -i 's/background { rgb <0.1, 0.5, 0.25> }/background { rgb <0.1, 0.48, 0.25> }/' elsewhere/scene/scene.pov
notice a_background_a_little_off_is_seen povray_is_right
export_to povray scene s.scene.json v.nrrd
mv elsewhere/scene/scene_dx.df3 swap && mv elsewhere/scene/scene_dy.df3 elsewhere/scene/scene_dx.df3 &&
    mv swap elsewhere/scene/scene_dy.df3
notice exchanged_files_are_seen povray_is_right
export_to povray scene s.scene.json other.nrrd
notice another_volume_is_seen povray_is_right
export_to povray scene s.scene.json v.nrrd
sed -i 's/ifndef (Iso_Pass) #declare Iso_Pass = 0/ifndef (Iso_Pass) #declare Iso_Pass = 1/' elsewhere/scene/scene.pov
notice another_pass_is_seen povray_is_right
before_moving=absolute_df3
absolute_df3() { sed -i "s|\"scene_scalar.df3\"|\"$PWD/here/scene/scene_scalar.df3\"|" here/scene/scene.inc; }
export_to povray scene s.scene.json v.nrrd
check a_path_was_planted grep -q "here/scene/scene_scalar.df3" elsewhere/scene/scene.inc
notice a_path_to_the_old_folder_is_seen povray_is_right
before_moving=

if has_cycles; then
    export_to blender s.blend s.scene.json v.nrrd
    check a_blend_shows_what_the_reference_shows blend_is_right
    check it_says_where_its_picture_goes blender -b elsewhere/s.blend --python-text "isoshade agreement" -f 1
    check beside_itself_in_floats test -s elsewhere/s_0001.exr
    cat >absolute.py <<'PY'
import bpy

for volume in bpy.data.volumes:
    volume.filepath = bpy.path.abspath(volume.filepath)
bpy.ops.wm.save_mainfile(relative_remap=False)
PY
    before_moving=absolute_vdb
    absolute_vdb() { blender -b here/s.blend -P absolute.py >log 2>&1; }
    export_to blender s.blend s.scene.json v.nrrd
    notice a_path_of_a_blend_to_the_old_folder_is_seen blend_is_right
else
    skip a_blend_shows_what_the_reference_shows "$lack"
fi
exit $failed
