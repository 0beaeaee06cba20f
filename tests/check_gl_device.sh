#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The device of the ray caster: listed, chosen, refused by name; the filter's bits as probed; the device's own timer.
. "$(dirname "$0")/lib.sh"
unset ISOSHADE_GL_DEVICE
"$ISOSHADE" make shells --size 16x14x12 -q -o v.nrrd || exit 1
draw() { "$ISOSHADE" render v.nrrd --size 24 -q --with gl "$@"; }

expect devices_are_listed 0 "$ISOSHADE" list --gl --json
cp out list.json
has_keys a_device list.json gl_devices choice vendor renderer version filter_bits_unorm8 filter_bits_unorm16 filter_bits_float timer_bits
check with_a_core_context grep -q '"version": "4\.[3-6] (Core Profile)' list.json
renderer=$(sed -n 's/.*"renderer": "\([^"]*\)".*/\1/p' list.json | head -n 1)
bits=$(json_number list.json filter_bits_float)
echo "# $renderer, filter of $bits bits"

expect by_its_number 0 draw --gl-device 0 --json -o number.exr
holds the_device_has_a_timer "$(json_number out device_seconds) > 0"
holds it_counts_no_more_than_the_clock "$(json_number out device_seconds) <= $(json_number out seconds) * 1.05 + 0.002"
expect by_its_name 0 draw --gl-device "$(tr '[:lower:]' '[:upper:]' <<<"${renderer%% *}")" -o name.exr
expect without_a_surface 0 draw --gl-device surfaceless -o surfaceless.exr
expect by_the_environment 0 env ISOSHADE_GL_DEVICE=0 "$ISOSHADE" render v.nrrd --size 24 -q -o environment.exr
for other in name environment; do
    check "the_same_device_draws_the_same_$other" "$ISOSHADE" compare number.exr $other.exr
done
refuse no_such_number 7 'no device "99"' draw --gl-device 99 -o x.exr
refuse no_such_name 7 'isoshade list --gl has them' draw --gl-device no-such-gpu -o x.exr

# llvmpipe filters bytes in 8 bits unless told otherwise before it starts: the probe notices, and codes travel in 16 bits.
if [[ $renderer == llvmpipe* ]]; then
    GALLIVM_PERF='' "$ISOSHADE" list --gl --json >coarse.json 2>err
    echo "# bytes: $(json_number list.json filter_bits_unorm8) bits, and by default $(json_number coarse.json filter_bits_unorm8)"
    holds a_coarse_filter_is_noticed "$(json_number coarse.json filter_bits_unorm8) <= 8 && $(json_number list.json filter_bits_unorm8) >= 20"
    holds floats_are_filtered_as_floats "$(json_number coarse.json filter_bits_float) >= 20"
    GALLIVM_PERF='' "$ISOSHADE" render v.nrrd --size 24 -q --gl-device 0 -o coarse.exr >log 2>&1
    "$ISOSHADE" compare coarse.exr number.exr --json >compare.json 2>err
    holds the_picture_does_not_change "$(json_number compare.json max_abs) < 2e-6"
else
    skip a_coarse_filter_is_noticed "$renderer is no software"
fi

# A device of 8 bits, by a probe that says so: pictures are those of exact lookups, and the name says why.
mkdir coarse && cp "$top"/src/render/gl/shaders/* coarse/
sed -i 's/^    color = .*/    color = vec4(round(256.0 * fraction) \/ 256.0);/' coarse/probe.glsl
draw --shader-dir coarse --json -o probed.exr >probed.json 2>err
check the_name_says_why grep -q 'linear filter of 8 bits"' probed.json
draw --exact-lookups -o exact.exr >log 2>&1
draw -o usual.exr >>log 2>&1
check pictures_are_those_of_exact_lookups "$ISOSHADE" compare probed.exr exact.exr
notice the_usual_ones "$ISOSHADE" compare probed.exr usual.exr
check the_header_says_it grep -qa 'linear filter of 8 bits' probed.exr
exit $failed
