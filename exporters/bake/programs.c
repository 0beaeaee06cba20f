/* SPDX-License-Identifier: MIT */
#include "bake/programs.h"

/* clang-format off */
static const iso_grid_program programs[] = {
    {.name = "blender", .summary = "density, color and emission; 1 unit is 1 m, z up; run in 3.4 and 4.3",
     .grids = "density,Cd=color,emission", .unit = "m", .up = "z",
     .tested = "Cycles of Blender 3.4.1 and 4.3.2 has the printed error",
     .setting = "Principled Volume: Density Attribute density, Density 1, Color and Absorption Color black, Emission Strength 1, "
                "Emission Color from an Attribute node that names emission; before Blender 5, which shifts all OpenVDB files, move "
                "the object back by half a point along each axis",
     .source = "https://docs.blender.org/manual/en/latest/modeling/volumes/introduction.html "
               "https://docs.blender.org/manual/en/latest/render/shader_nodes/shader/volume_principled.html"},
    {.name = "houdini", .summary = "density and Cd, fog volumes; 1 unit is 1 m, y up; not run",
     .grids = "density,Cd", .unit = "m", .up = "y",
     .tested = "not run",
     .setting = "File SOP; the Pyro shader's density from density, its scattering color from Cd",
     .source = "https://www.sidefx.com/docs/houdini/nodes/sop/vdb.html "
               "https://www.sidefx.com/docs/houdini/nodes/sop/labs--volume_texture-1.0.html"},
    {.name = "karma", .summary = "density, Cd and emission through USD; 1 unit is 1 m, y up; not run",
     .grids = "density,Cd,emission", .unit = "m", .up = "y", .usd = true,
     .tested = "not run",
     .setting = "reference the .usda; Karma Volume: Absorption from density, which is per meter as it expects, Emission from "
                "emission, Scattering 0",
     .source = "https://www.sidefx.com/docs/houdini/nodes/vop/kma_volume.html "
               "https://openusd.org/release/user_guides/schemas/usdVol/OpenVDBAsset.html"},
    {.name = "unreal", .summary = "density, Cd and emission as half floats; 1 unit is 1 cm, z up; not run",
     .grids = "density,Cd,emission", .unit = "cm", .up = "z", .half = true,
     .tested = "not run",
     .setting = "Sparse Volume Texture: density in attributes A, the rest in B as 16-bit float; the extinction exceeds 1 if "
                "a centimeter hides much, so not 8-bit unorm; Unreal's axes are left-handed: compare a view for a mirror image",
     .source = "https://dev.epicgames.com/documentation/en-us/unreal-engine/heterogeneous-volumes-in-unreal-engine "
               "https://dev.epicgames.com/documentation/en-us/unreal-engine/sparse-volume-textures-in-unreal-engine"},
    {.name = "arnold", .summary = "density, Cd and emission; 1 unit is 1 cm, y up, as in Maya; not run",
     .grids = "density,Cd,emission", .unit = "cm", .up = "y",
     .tested = "not run",
     .setting = "Volume node: Grids \"density Cd emission\"; Standard Volume: Density Channel density, Scatter Color Channel Cd; or "
                "Emission Mode channel, emission; for HtoA --scene-unit m",
     .source = "https://help.autodesk.com/view/ARNOL/ENU/?guid=arnold_for_houdini_volumes_ah_Arnold_Volume_html "
               "https://help.autodesk.com/view/ARNOL/ENU/?guid=arnold_user_guide_ac_surface_shaders_ac_volume_rgb_html"},
    {.name = "embergen", .summary = "density and temperature as half floats; 1 unit is 1 m, y up; not run",
     .grids = "density,temperature", .unit = "m", .up = "y", .half = true,
     .tested = "not run",
     .setting = "as in its own files: scalars by these names, as half floats; colors by a ramp over temperature",
     .source = "https://gist.github.com/vassvik/ffd1e90c0f46f80ddc2674bba11d48f4"},
};
/* clang-format on */

const iso_names iso_grid_program_names = ISO_NAMES_OF_ROWS("grid program", programs);

const iso_grid_program *iso_grid_program_at(size_t row)
{
    return &programs[row];
}
