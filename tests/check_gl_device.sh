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
check with_a_core_context grep -q '"version": "4\.[3-6]' list.json
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

# A device whose filter keeps 8 bits, imitated: places are rounded to 1/256 texel before the texture unit gets them. By its
# probe the shader filters instead, so that the pictures stay; where the probe does not notice it, they change.
mkdir deaf coarse
cp "$top"/src/render/gl/shaders/* deaf/
size='vec3(textureSize(texels, 0))'
rounded="(floor((p * $size - 0.5) * 256.0 + 0.5) / 256.0 + 0.5) / $size"
sed -i "s|^\(vec4 filtered(.*textureLod(texels, \)p\(, 0.0); }\)$|\1$rounded\2|" deaf/raycast.glsl
cp deaf/* coarse/
sed -i 's/^    color = .*/    color = vec4(round(256.0 * fraction) \/ 256.0);/' coarse/probe.glsl
check the_filter_is_imitated grep -q '^vec4 filtered.*256' coarse/raycast.glsl
draw --shader-dir coarse --json -o probed.exr >probed.json 2>err
check the_name_says_why grep -q 'linear filter of 8 bits"' probed.json
check the_header_says_it grep -qa 'linear filter of 8 bits' probed.exr
"$ISOSHADE" build v.nrrd -q -o v.iso >log 2>&1 || exit 1
declare -A kinds=([integral]='' [surface]='--isosurface 0.5' [preintegrated]='--quadrature preintegrated'
    [region]='--level 1 --roi 3,3,3,12,10,9' [bricks]='--plan-error 0.001')
for kind in "${!kinds[@]}"; do
    for shaders in "$top/src/render/gl/shaders" coarse deaf; do
        "$ISOSHADE" render v.iso --size 24 -q --with gl ${kinds[$kind]} --shader-dir "$shaders" -o "$kind-${shaders##*/}.exr" >>log 2>&1
    done
    for shaders in coarse deaf; do "$ISOSHADE" compare $kind-shaders.exr $kind-$shaders.exr --json >$kind-$shaders.json 2>>log; done
    # Filtered in float on both sides, at most some of its last bits apart.
    holds "${kind}_does_not_change" "$(json_number $kind-coarse.json max_abs) < 5e-6"
    if [[ $renderer == llvmpipe* ]]; then
        holds "${kind}_would_change" "$(json_number $kind-deaf.json max_abs) > 5e-5"
    fi
done
exit $failed
