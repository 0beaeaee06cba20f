#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The scripts of exports under Blender 5 and later, where a build without NanoVDB ends them at the calibration, before any
# scene is built: all kinds of scenes are built without it, with warnings of deprecated calls as errors, and opened again.
# (Where Cycles shows volumes, check_export.sh, check_opened.sh and others build them all.)
. "$(dirname "$0")/lib.sh"
blender=$(command -v "${ISOSHADE_BLENDER:-blender}") || { skip blender_api "no Blender"; exit $failed; }
version=$("$blender" --version 2>/dev/null | sed -n 's/^Blender \([0-9]*\).*/\1/p' | head -n 1)
[ "${version:-0}" -ge 5 ] || [ -n "${ISOSHADE_TEST_API-}" ] || { skip blender_api "Blender ${version:-?}: other tests build its scenes"; exit $failed; }

cat >uncalibrated <<END
#!/usr/bin/env bash
for a; do
    case \$a in */build_scene.py) sed -i -e 's/^\( *shift = \)calibrate(.*/\10.0/' -e '1i import warnings; warnings.simplefilter("error", DeprecationWarning)' "\$a" ;; esac
done
exec "$blender" "\$@"
END
chmod +x uncalibrated
export ISOSHADE_BLENDER=$dir/uncalibrated
scene=$top/refscenes/shells.scene.json
"$ISOSHADE" make shells --size 21x30x17 -q -o v.nrrd && "$ISOSHADE" make noise --size 12 --type uint8 -q -o w_0000.nrrd && cp w_0000.nrrd w_0001.nrrd || exit 1
to() { "$ISOSHADE" export "$1" --to blender -q -o "${@:2}"; }
check levels_adapted to v.nrrd levels.blend --scene "$scene" --levels 2 --adapt
check a_2d_transfer_function to v.nrrd two.blend --scene "$scene" --level 1 --adapt --tf-2d gradient
check an_extinction_scale to v.nrrd scaled.blend --scene "$scene" --level 1 --adapt --extinction-scale
check a_region_of_interest to v.nrrd roi.blend --scene "$scene" --level 1 --roi 4,4,4,12,12,12
check the_physical_material to v.nrrd physical.blend --scene "$scene" --material physical
check labels to w_0000.nrrd labels.blend --labels
check a_sequence to w_%04d.nrrd sequence.blend --frames all
check several to v.nrrd several.blend --add w_0000.nrrd
cat >read.py <<'END'
import bpy
for name in ("levels", "two", "scaled", "roi", "physical", "labels", "sequence", "several"):
    bpy.ops.wm.open_mainfile(filepath=f"{name}.blend")
    looks = [m.node_tree.nodes["isoshade"] for m in bpy.data.materials if m.node_tree and "isoshade" in m.node_tree.nodes]
    volumes = [o for o in bpy.data.objects if o.type == 'VOLUME']
    print("api:", name, "yes" if looks and volumes and all(v.data.grids.load() for v in volumes) else "no", flush=True)
END
"$blender" -b --factory-startup -P read.py >out 2>&1
while read -r _ name answer; do
    check "opened_$name" test "$answer" = yes
done < <(grep '^api: ' out)
check all_were_opened test "$(grep -c '^api: ' out)" = 8 || tail -5 out
exit $failed
