#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Several volumes in one .blend: added ones, channels, a label map beside a field; what overlaps adds up; each is switched by
# itself; and two files that are appended into a third.
. "$(dirname "$0")/lib.sh"
# Two slabs of constant extinction, which overlap by half: T = 1/2 and 1/4 behind each, 8 mm thick. Both white.
python3 - <<'PY'
def write(name, value, origin, size=(8, 8, 8), kind="uchar", more=""):
    with open(name, "wb") as file:
        file.write(f"NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {size[0]} {size[1]} {size[2]}\nspace dimension: 3\n"
                   f"space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: ({origin[0]},{origin[1]},{origin[2]})\n"
                   f"encoding: raw\n{more}\n".encode() + bytes(value(i) for i in range(size[0] * size[1] * size[2])))
write("a.nrrd", lambda i: 100, (0, 0, 0))
write("b.nrrd", lambda i: 100, (4, 0, 0))
write("seg.nrrd", lambda i: 5 if i % 8 < 3 else 0, (0, 0, 0), more="Segment0_ID:=liver\nSegment0_LabelValue:=5\n")
with open("two.nrrd", "wb") as file: # a ball in each channel
    ball = lambda i, c: max(0, 250 - 30 * ((i % 8 - 2 - 3 * c) ** 2 + (i // 8 % 8 - 4) ** 2 + (i // 64 - 4) ** 2))
    file.write(b"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 8 8 8\nkinds: vector domain domain domain\nspace dimension: 3\n"
               b"space directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n")
    file.write(bytes(ball(i, c) for i in range(512) for c in (0, 1)))
tf = '''{"schema": "isoshade.tf/1", "range": [0, 200], "unit_distance_mm": 8, "color_space": "linear", "table_size": 3, "points": [
 {"value": 0, "r": %s, "g": %s, "b": 1, "opacity": %s}, {"value": 200, "r": %s, "g": %s, "b": 1, "opacity": %s}]}'''
half, quarter = tf % (1, 1, .5, 1, 1, .5), tf % (1, 0, .75, 1, 0, .75)
open("quarter.tf.json", "w").write(quarter)
open("s.scene.json", "w").write('''{"schema": "isoshade.scene/1", "image": {"width": 4, "height": 4},
 "camera": {"projection": "orthographic", "position": [4, 4, 50], "look_at": [4, 4, 4], "up": [0, 1, 0], "height_mm": 16},
 "lights": [{"direction": [0, 0, 1], "space": "world", "intensity": 1}],
 "shading": {"ambient": 1, "diffuse": 0, "specular": 0, "power": 8}, "background": [0, 0, 0], "step_voxels": 0.05, "tf": %s}''' % half)
PY
expect two_volumes 0 "$ISOSHADE" export a.nrrd --add b.nrrd,quarter.tf.json --to blender --scene s.scene.json -o ab.blend -q
expect a_field_and_its_labels 0 "$ISOSHADE" export a.nrrd --add seg.nrrd --to blender --scene s.scene.json -o seg.blend -q
expect channels_with_levels 0 "$ISOSHADE" export two.nrrd --channels all --levels 2 --to blender --scene s.scene.json \
    -o levels.blend -q
expect channels_of_the_second_level 0 "$ISOSHADE" export two.nrrd --channels all --level 1 --to blender --scene s.scene.json \
    -o second.blend -q
expect labels_with_levels 0 "$ISOSHADE" export a.nrrd --add seg.nrrd --levels 2 --to blender --scene s.scene.json \
    -o both.blend -q
expect channels 0 "$ISOSHADE" export two.nrrd --channels all --to blender --scene s.scene.json -o channels.blend
has_cycles && check each_has_a_color grep -q 'channel_1: magenta' out
for s in a b; do "$ISOSHADE" export $s.nrrd --to blender --scene s.scene.json -o $s.blend -q >out 2>err || not_ok single "$(cat err)"; done
if has_cycles; then
    has_files grids . ab_a.vdb ab_b.vdb seg_a.vdb seg_seg.vdb channels_channel_0.vdb channels_channel_1.vdb \
        levels_channel_1_level_0.vdb levels_channel_1_level_1.vdb both_seg_level_1.vdb
    cat >driver.py <<'PY'
import bpy, os
here = os.getcwd()
def draw(name):
    scene = bpy.context.scene
    scene.render.film_transparent = True
    exec(bpy.data.texts["isoshade agreement"].as_string()) # one sample through the middle of each pixel
    scene.render.filepath = os.path.join(here, name + ".exr")
    bpy.context.view_layer.update()
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    p = image.pixels[:]
    # columns at x = -2, 2, 6 and 10; a row through the middle
    print("pixels", name, *(f"{p[4 * (8 + x) + c]:.5f}" for x in range(4) for c in range(4)))
def show(**which):
    for name, value in which.items():
        bpy.data.objects[name]["show"] = value
        bpy.data.objects[name].update_tag()
def opens(name):
    bpy.ops.wm.open_mainfile(filepath=os.path.join(here, name))
opens("ab.blend")
draw("both")
show(b=0)
draw("only_a")
show(a=0, b=1)
draw("only_b")
print("lights", len([o for o in bpy.data.objects if o.type == 'LIGHT']))
opens("a.blend")
draw("alone_a")
opens("seg.blend")
print("classes", "isoshade labels" in bpy.data.images, sorted(o.name for o in bpy.data.objects if "show" in o))
draw("seg")
show(seg=0)
draw("no_seg")
opens("channels.blend")
for name, on in (("channel_both", (1, 1)), ("channel_first", (1, 0)), ("channel_second", (0, 1))):
    show(channel_0=on[0], channel_1=on[1])
    draw(name)
# Each volume has levels of its own.
def level(**which):
    for name, value in which.items():
        bpy.data.objects[name]["level"] = value
        bpy.data.objects[name].update_tag()
opens("second.blend")
draw("second")
show(channel_1=0)
draw("second_first")
opens("levels.blend")
draw("levels_fine")
level(channel_0=1, channel_1=1)
draw("levels_coarse")
show(channel_1=0)
draw("levels_first")
level(channel_1=0)
draw("levels_hidden")
opens("both.blend")
level(seg=1)
draw("both_coarse")
show(seg=0)
draw("both_hidden")
# Two exports of one volume each, appended into a file of a person: names that collide are numbered, drivers hold.
opens("a.blend")
for name in ("b",):
    with bpy.data.libraries.load(os.path.join(here, name + ".blend"), relative=False) as (source, target):
        target.collections = [name]
    bpy.context.scene.collection.children.link(target.collections[0])
draw("appended")
print("drivers", all(c.driver.is_valid for m in bpy.data.materials for c in (m.node_tree.animation_data.drivers if m.node_tree and m.node_tree.animation_data else ())))
bpy.data.objects["isoshade light 1.001"].rotation_euler = (1, 0, 0)
bpy.context.view_layer.update()
print("turned", *(f"{v:.4f}" for v in bpy.data.materials["b"].node_tree.nodes["isoshade"].inputs["Light 1"].default_value))
print("left", *(f"{v:.4f}" for v in bpy.data.materials["a"].node_tree.nodes["isoshade"].inputs["Light 1"].default_value))
PY
    blender -b --factory-startup -P driver.py >log 2>&1
    # pixel NAME COLUMN CHANNEL: columns 0 to 3, channels 0 to 3
    pixel() { awk -v n="$1" -v at=$((3 + 4 * $2 + $3)) '$1 == "pixels" && $2 == n {print $at}' log; }
    # near NAME VALUE WANTED: one sample in each pixel, single precision
    near() { holds "$1" "\"$2\" != \"\" && ($2 - ($3)) < 2e-3 && ($3 - ($2)) < 2e-3"; }
    near a_alone_lets_half_through "$(pixel both 1 3)" 0.5
    near b_alone_a_quarter "$(pixel both 3 3)" 0.75
    near together_an_eighth "$(pixel both 2 3)" 0.875
    # white of sigma 1 and magenta of sigma 2: green is that of a, a third of what both emit
    near their_emission_adds_up "$(pixel both 2 0)" 0.875
    near by_their_extinctions "$(pixel both 2 1)" 0.875/3
    near nothing_beside_them "$(pixel both 0 3)" 0
    near b_can_be_hidden "$(pixel only_a 2 3)" 0.5
    near and_a "$(pixel only_b 2 3)" 0.75
    near where_it_is_not "$(pixel only_b 1 3)" 0
    near as_a_single_export "$(pixel only_a 1 0)" "$(pixel alone_a 1 0)"
    check one_set_of_lights grep -q '^lights 1$' log
    check labels_stand_beside_a_field grep -q "^classes True \['a', 'seg'\]" log
    holds they_are_seen "$(pixel seg 1 3) > $(pixel no_seg 1 3) + 0.05"
    near and_hidden "$(pixel no_seg 1 3)" 0.5
    holds the_first_channel_is_green "$(pixel channel_first 1 1) > 0.1 && $(pixel channel_first 1 0) < 0.02"
    holds the_second_magenta "$(pixel channel_second 2 0) > 0.1 && $(pixel channel_second 2 1) < 0.02 && $(pixel channel_second 2 2) > 0.1"
    holds both_are_there "$(pixel channel_both 1 1) > 0.05 && $(pixel channel_both 2 0) > 0.05"
    for column in 1 2; do
        for channel in 0 1; do
            near "levels_of_channels_$column$channel" "$(pixel levels_coarse $column $channel)" "$(pixel second $column $channel)"
            near "one_alone_$column$channel" "$(pixel levels_first $column $channel)" "$(pixel second_first $column $channel)"
            near "hidden_at_any_level_$column$channel" "$(pixel levels_hidden $column $channel)" \
                "$(pixel second_first $column $channel)"
        done
        near "the_finest_comes_first_$column" "$(pixel levels_fine $column 0)" "$(pixel channel_both $column 0)"
    done
    holds and_is_another "$(pixel levels_fine 1 1) - $(pixel levels_coarse 1 1) > 0.01 || $(pixel levels_coarse 1 1) - $(pixel levels_fine 1 1) > 0.01"
    holds labels_have_levels_too "$(pixel both_coarse 1 3) > $(pixel both_hidden 1 3) + 0.05"
    near appended_they_add_up_too "$(pixel appended 2 3)" 0.75
    near appended_each_is_itself "$(pixel appended 3 3)" 0.5
    check drivers_hold grep -q '^drivers True' log
    check a_light_turns_its_own_volume grep -q '^turned 0.0000 -0.8415 0.5403' log
    check and_no_other grep -q '^left 0.0000 -*0.0000 1.0000' log
    grep -q '^pixels' log || tail -5 log
fi
refuse no_such_file 3 "none.nrrd" "$ISOSHADE" export a.nrrd --add none.nrrd --to blender --scene s.scene.json -o x.blend -q
refuse one_volume_for_povray 2 "--to povray takes a single volume" "$ISOSHADE" export a.nrrd --add b.nrrd --to povray --scene s.scene.json -o x -q
refuse channels_of_one 2 "has one channel" "$ISOSHADE" export a.nrrd --channels all --to blender --scene s.scene.json -o x.blend -q
refuse no_such_channel 2 '--channel is "7"' "$ISOSHADE" export two.nrrd --channels 0,7 --to blender --scene s.scene.json -o x.blend -q
refuse one_table_for_all 2 "--adapt needs a single volume" "$ISOSHADE" export a.nrrd --add b.nrrd --adapt --level 0 --to blender --scene s.scene.json -o x.blend -q
exit $failed
