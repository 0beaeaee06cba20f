/* SPDX-License-Identifier: MIT */
/* Cycles and the exported .blend against the converged reference. Blender has to be there. */
#define _GNU_SOURCE
#include "difference.h"
#include "sampled.h"
#include "cycles.h"

#include <sys/stat.h>

#include "base/file.h"
#include "base/process.h"
#include "blender/blender.h"
#include "compare/metrics.h"
#include "render/reference.h"
#include "volume/synthetic.h"

static const char soft_tf[] =
    "{\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", \"unit_distance_voxels\": 4, \"color_space\": \"linear\","
    " \"table_size\": 256, \"points\": ["
    "{\"value\": 0, \"r\": 0.1, \"g\": 0.3, \"b\": 0.8, \"opacity\": 0.02},"
    "{\"value\": 0.45, \"r\": 0.9, \"g\": 0.5, \"b\": 0.2, \"opacity\": 0.1},"
    "{\"value\": 1, \"r\": 0.9, \"g\": 0.9, \"b\": 0.3, \"opacity\": 0.6}]}";
static const char thin_tf[] =
    "{\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", \"unit_distance_voxels\": 1, \"color_space\": \"linear\","
    " \"table_size\": 256, \"points\": ["
    "{\"value\": 0.4, \"r\": 0.1, \"g\": 0.5, \"b\": 0.7, \"opacity\": 0},"
    "{\"value\": 0.5, \"r\": 0.2, \"g\": 0.8, \"b\": 0.6, \"opacity\": 0.5},"
    "{\"value\": 0.6, \"r\": 0.9, \"g\": 0.8, \"b\": 0.2, \"opacity\": 0}]}";

typedef struct scene_case {
    iso_field_kind field;
    iso_type type;
    double shear, scale; /* 0: 1 */
    bool orthographic;
    size_t level;
    const char *tf;
    iso_vec3 away_mm; /* where its corner is moved to, by */
    bool clipped;
} scene_case;

/* 5 mm of volume 60 m from the origin: there single precision steps by 4 micrometers, a twentieth of a voxel. */
static const scene_case far_away = {.field = ISO_FIELD_NOISE,
                                    .type = ISO_I16,
                                    .scale = 0.1,
                                    .tf = soft_tf,
                                    .away_mm = {52000.3, -31000.1, 8000.2},
                                    .clipped = true};

/* What a case renders: the pyramid, the view, and their files' folder. */
typedef struct subject {
    char *dir;
    iso_pyramid pyramid;
    iso_view view;
} subject;

/* Unequal odd sizes and spacings, rotated axes; overhanging at level 1. */
static iso_geometry skew_geometry(double shear, double scale)
{
    const size_t size[3] = {31, 45, 23};
    const double spacing[3] = {1, 1.25, 2.5}, c = cos(0.5), s = sin(0.5);
    const iso_mat3 turn = {{{c, -s * 0.6, s * 0.8}, {s, c * 0.6, -c * 0.8}, {0, 0.8, 0.6}}};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k)
            g.index_to_world.m[r][k] = turn.m[r][k] * spacing[k] + (k == 1 ? shear * turn.m[r][0] : 0);
    g.origin_mm = iso_v3(-31.25, 7.5, 60.125);
    if (scale != 0) { /* below 0: left-handed */
        g.index_to_world = iso_mat3_scale(g.index_to_world, scale);
        g.origin_mm = iso_scale(g.origin_mm, scale);
    }
    return g;
}

static void make_view(const char *dir, const iso_pyramid *p, const scene_case *c, iso_view *view)
{
    char text[4000];
    int n = snprintf(text, sizeof text,
                     "{\"schema\": \"isoshade.scene/1\", \"image\": {\"width\": 48, \"height\": 40},"
                     " \"camera\": {\"projection\": \"%s\", \"fit\": true, \"direction\": [-1, 1.5, -0.7],"
                     " \"up\": [0, 0, 1], \"margin\": 0.95, \"fov_y_deg\": 35},"
                     " \"lights\": [{\"direction\": [-0.6, 0.5, 1], \"space\": \"camera\", \"intensity\": 0.7},"
                     " {\"direction\": [1, 0.4, 0.2], \"space\": \"world\", \"intensity\": 0.3}],"
                     " \"shading\": {\"ambient\": 0.2, \"diffuse\": 0.8, \"specular\": 0.3, \"power\": 30},"
                     " \"background\": [0.2, 0.1, 0.3], \"step_voxels\": 0.25, %s\"tf\": %s}",
                     c->orthographic ? "orthographic" : "perspective",
                     c->clipped ? "\"clip_planes\": [{\"normal\": [0.3, 1, 0.2], \"at\": 0.4}], " : "", c->tf);
    FREED char *path = iso_path_join(dir, "case.scene.json");
    OWNED(iso_scene) scene = {0};
    assert_ok(iso_file_write(path, text, (size_t)n, &err));
    assert_ok(iso_scene_load(path, &scene, &err));
    assert_ok(iso_scene_resolve(&scene, &p->levels[0].geometry, p->levels[0].min, p->levels[0].max, view, &err));
}

static subject open_subject(const scene_case *c)
{
    subject s = {.dir = iso_make_temp_dir()};
    iso_field field = {.kind = c->field, .geometry = skew_geometry(c->shear, c->scale), .seed = 5};
    field.geometry.origin_mm = iso_add(field.geometry.origin_mm, c->away_mm);
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2;
    s.pyramid = sampled_pyramid(&field, c->type, &opt);
    make_view(s.dir, &s.pyramid, c, &s.view);
    return s;
}

static void close_subject(subject *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
    iso_remove_tree(s->dir);
    free(s->dir);
}

static iso_image reference(const subject *s, size_t level, const iso_view *view)
{
    iso_image image;
    iso_reference_options opt = iso_reference_defaults();
    assert_ok(iso_reference_render(&s->pyramid.levels[level], s->pyramid.options.code, view, &opt, &image, NULL, &err));
    return image;
}

static iso_image cycles(const subject *s, size_t level, double step_voxels)
{
    iso_image image;
    iso_blender_options opt = iso_blender_defaults();
    opt.step_voxels = step_voxels;
    assert_ok(iso_cycles_render(&s->pyramid, level, &s->view, &opt, &image, NULL, &err));
    return image;
}

/* Pictures of a .blend have the background in and no alpha. */
static double rmse_of_color(const iso_image *a, const iso_image *b)
{
    double sum = 0;
    assert_true(a->width == b->width && a->height == b->height);
    for (size_t i = 0; i < 4 * a->width * a->height; ++i)
        if (i % 4 != 3)
            sum += pow((double)a->rgba[i] - (double)b->rgba[i], 2);
    return sqrt(sum / (3 * (double)(a->width * a->height)));
}

/* What is left is the step: 1e-6 to 2e-5 on smooth TFs, about 1e-4 on thin shells. */
#define SMOOTH_LIMIT 1e-4
#define THIN_LIMIT 1e-3

static void check_case(const scene_case *c, double limit)
{
    ENDED_BY(close_subject) subject s = open_subject(c);
    OWNED(iso_image) want = reference(&s, c->level, &s.view), have = cycles(&s, c->level, 1.0 / 16);
    float seen = 0;
    for (size_t i = 3; i < 4 * want.width * want.height; i += 4)
        seen = fmaxf(seen, want.rgba[i]);
    assert_more_than((double)seen, 0.3); /* the volume is in the picture */
    assert_at_most(difference_of(&have, &want).rmse, limit);
}

/* Values of both signs, and opacity at the border: the box is cut within a step. */
VALUES_TEST(a_soft_opaque_border_agrees_in_perspective)
{
    need_cycles();
    check_case(&(scene_case){.field = ISO_FIELD_NOISE, .type = ISO_I16, .tf = soft_tf}, SMOOTH_LIMIT);
}

VALUES_TEST(an_overhanging_sheared_level_agrees_orthographically)
{
    need_cycles();
    check_case(&(scene_case){.field = ISO_FIELD_RAMP,
                             .type = ISO_F32,
                             .shear = 0.4,
                             .orthographic = true,
                             .level = 1,
                             .tf = soft_tf},
               SMOOTH_LIMIT);
}

/* As in many scans: the determinant of index_to_world is below 0, of which Blender by itself draws nothing right. */
VALUES_TEST(a_left_handed_grid_agrees)
{
    need_cycles();
    check_case(
        &(scene_case){.field = ISO_FIELD_NOISE, .type = ISO_U8, .shear = 0.3, .scale = -1, .level = 1, .tf = soft_tf},
        SMOOTH_LIMIT);
}

/* Voxels of a tenth of a micrometer: Blender's single precision would lose them in its own unit. A plane cuts them. */
VALUES_TEST(thin_shells_under_the_microscope_agree_at_a_coarse_level)
{
    need_cycles();
    check_case(&(scene_case){.field = ISO_FIELD_SHELLS,
                             .type = ISO_U8,
                             .scale = 1e-4,
                             .orthographic = true,
                             .level = 1,
                             .tf = thin_tf,
                             .clipped = true},
               THIN_LIMIT);
}

/* Error bar: the pictures at h/8 and h/16 are apart by what h/16 still errs, or more. Then the planted faults: each
 * makes another reference, which Cycles' picture must not agree with. */
TEST(thin_shells_agree_within_the_error_bar_and_faults_do_not)
{
    need_cycles();
    ENDED_BY(close_subject)
    subject s = open_subject(&(scene_case){.field = ISO_FIELD_SHELLS, .type = ISO_F32, .tf = thin_tf});
    OWNED(iso_image) want = reference(&s, 0, &s.view), fine = cycles(&s, 0, 1.0 / 16), coarse = cycles(&s, 0, 1.0 / 8);
    double error = difference_of(&fine, &want).rmse, bar = difference_of(&fine, &coarse).rmse;
    assert_at_most(error, THIN_LIMIT);
    assert_at_most(error, bar);
    assert_at_most(bar, 10 * THIN_LIMIT);

    iso_level *level = &s.pyramid.levels[0];
    iso_geometry right = level->geometry;
    level->geometry.origin_mm = iso_madd(right.origin_mm, iso_column(right.index_to_world, 0), 0.5);
    iso_image wrong = reference(&s, 0, &s.view); /* half a voxel */
    assert_more_than(difference_of(&fine, &wrong).rmse, THIN_LIMIT);
    iso_image_destroy(&wrong);
    level->geometry = right;

    for (int r = 0; r < 3; ++r) { /* x and y exchanged */
        level->geometry.index_to_world.m[r][0] = right.index_to_world.m[r][1];
        level->geometry.index_to_world.m[r][1] = right.index_to_world.m[r][0];
    }
    wrong = reference(&s, 0, &s.view);
    assert_more_than(difference_of(&fine, &wrong).rmse, THIN_LIMIT);
    iso_image_destroy(&wrong);
    level->geometry = right;

    iso_vec3 light = s.view.lights[0].direction;
    s.view.lights[0].direction = iso_sub(iso_scale(s.view.camera.right, 2 * iso_dot(light, s.view.camera.right)),
                                         light);
    wrong = reference(&s, 0, &s.view); /* light from the other side */
    assert_more_than(difference_of(&fine, &wrong).rmse, THIN_LIMIT);
    iso_image_destroy(&wrong);
    s.view.lights[0].direction = light;

    for (size_t i = 0; i < 4 * s.view.tf.count; ++i) /* colors taken for sRGB */
        if (i % 4 != 3)
            s.view.tf.entries[i] = powf(s.view.tf.entries[i], 2.2f);
    wrong = reference(&s, 0, &s.view);
    assert_more_than(difference_of(&fine, &wrong).rmse, THIN_LIMIT);
    iso_image_destroy(&wrong);
}

/* Steps and seeds change from frame to frame, nothing else: each picture is that of a run of its own. */
TEST(frames_of_one_run_are_the_pictures_of_single_runs)
{
    need_cycles();
    ENDED_BY(close_subject)
    subject s = open_subject(&(scene_case){.field = ISO_FIELD_SHELLS, .type = ISO_F32, .tf = thin_tf});
    iso_blender_options frames[3] = {iso_blender_defaults(), iso_blender_defaults(), iso_blender_defaults()};
    frames[0].step_voxels = 1.0 / 8;
    frames[1].step_voxels = frames[2].step_voxels = 1.0 / 2;
    frames[1].seed = 7;
    iso_image pictures[3], alone;
    assert_ok(iso_cycles_render_frames(&s.pyramid, 0, &s.view, &(iso_blender_frames){frames, 3, pictures}, NULL, &err));
    assert_ok(iso_cycles_render(&s.pyramid, 0, &s.view, &frames[1], &alone, NULL, &err));
    assert_at_most(difference_of(&pictures[1], &alone).rmse, 1e-7);         /* threads may differ in the last bit */
    assert_more_than(difference_of(&pictures[1], &pictures[0]).rmse, 1e-4); /* another step */
    assert_more_than(difference_of(&pictures[1], &pictures[2]).rmse, 1e-4); /* another seed */
    frames[2].step_voxels = -1;
    for (int i = 0; i < 3; ++i)
        iso_image_destroy(&pictures[i]);
    assert_status(iso_cycles_render_frames(&s.pyramid, 0, &s.view, &(iso_blender_frames){frames, 3, pictures}, NULL,
                                           &err),
                  ISO_E_RANGE);
    assert_null(pictures[0].rgba); /* all or none */
    iso_image_destroy(&alone);
}

/* Cycles takes seeds that differ in their last bit alone for the same one: what is given to it differs elsewhere
 * too. */
VALUES_TEST(each_seed_has_a_noise_of_its_own)
{
    need_cycles();
    enum { count = 6 };
    ENDED_BY(close_subject)
    subject s = open_subject(&(scene_case){.field = ISO_FIELD_SHELLS, .type = ISO_F32, .tf = thin_tf});
    iso_blender_options frames[count];
    iso_image pictures[count];
    for (int i = 0; i < count; ++i) {
        frames[i] = iso_blender_defaults();
        frames[i].step_voxels = 1.0 / 2;
        frames[i].seed = i;
    }
    assert_ok(
        iso_cycles_render_frames(&s.pyramid, 0, &s.view, &(iso_blender_frames){frames, count, pictures}, NULL, &err));
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < i; ++k)
            assert_more_than(difference_of(&pictures[i], &pictures[k]).rmse, 1e-4);
    for (int i = 0; i < count; ++i)
        iso_image_destroy(&pictures[i]);
}

/* Runs Blender on a .blend with a script of its user. */
static void run_script(const char *blend, const char *script_text)
{
    FREED char *blender = NULL, *script = NULL;
    assert_true(asprintf(&script, "%s.py", blend) > 0);
    assert_ok(iso_file_write(script, script_text, strlen(script_text), &err));
    assert_ok(iso_process_find("blender", "blender", &blender, &err));
    const char *argv[] = {blender, "-b", "--factory-startup", "--python-exit-code", "9", blend, "-P", script, NULL};
    const iso_process_options options = {.sandbox = {.kind = ISO_SANDBOX_NONE}}; /* as the user would start it */
    assert_ok(iso_process_run(argv, &options, &err));
}

/* The user's view of it: the folder is moved, the level switched, the volume turned. */
static const char user_script[] =
    "import bpy, math\n"
    "from mathutils import Matrix\n"
    "scene, frame = bpy.context.scene, bpy.data.objects['two']\n"
    "exec(bpy.data.texts['isoshade agreement'].as_string())\n"
    "def render(name):\n"
    "    scene.render.image_settings.file_format = 'OPEN_EXR'\n"
    "    scene.render.filepath = '//' + name\n"
    "    bpy.ops.render.render(write_still=True)\n"
    "def switch(level):\n"
    "    frame['level'] = level\n"
    "    frame.update_tag()\n"
    "    bpy.context.view_layer.update()\n"
    "render('level_0.exr')\n"
    "switch(1)\n"
    "render('level_1.exr')\n"
    /* everything turned and scaled alike: the same picture, if normals and opacity follow the object */
    "volumes = [thing for thing in frame.children if thing.type == 'VOLUME']\n"
    "look = volumes[0].active_material.node_tree.nodes[0]\n"
    "turn = Matrix.Rotation(0.7, 4, (1, 2, 3)) @ Matrix.Scale(0.25, 4)\n"
    "frame.matrix_world = turn\n"
    "camera = scene.camera\n"
    "place = turn @ camera.matrix_world\n"
    "camera.matrix_world = Matrix.LocRotScale(place.to_translation(), place.to_quaternion(), (1, 1, 1))\n"
    "for sun in ('isoshade light 1', 'isoshade light 2'):\n"
    "    bpy.data.objects[sun].matrix_world = turn @ bpy.data.objects[sun].matrix_world\n"
    "bpy.context.view_layer.update()\n"
    "render('turned.exr')\n"
    "look.inputs['Use Ramp'].default_value = 1\n"
    "render('ramp.exr')\n";

static iso_image load(const char *dir, const char *name)
{
    iso_image image = {0};
    FREED char *path = iso_path_join(dir, name);
    assert_ok(iso_image_load_exr(path, &image, &err));
    return image;
}

/* Level 1 has other colors, another range and fewer entries, as adapted tables do. */
static void make_tables(const iso_tf_table *tf, iso_tf_table tables[2])
{
    for (int k = 0; k < 2; ++k) {
        tables[k] = *tf;
        tables[k].count = k == 0 ? tf->count : 100;
        tables[k].hi = k == 0 ? tf->hi : 0.5 * (tf->lo + tf->hi);
        tables[k].entries = malloc(4 * tf->count * sizeof *tf->entries);
        for (size_t i = 0; i < 4 * tables[k].count; ++i)
            tables[k].entries[i] = tf->entries[i] * (k == 1 && i % 4 != 3 ? 0.5f : 1);
    }
}

TEST(an_exported_scene_can_be_moved_switched_and_turned)
{
    need_cycles();
    ENDED_BY(close_subject)
    subject s = open_subject(&(scene_case){.field = ISO_FIELD_SPHERE, .type = ISO_F32, .tf = soft_tf});
    FREED char *made = iso_path_join(s.dir, "made"), *moved = iso_path_join(s.dir, "moved");
    FREED char *first = iso_path_join(made, "two.blend"), *blend = iso_path_join(moved, "two.blend");
    iso_tf_table tables[2];
    make_tables(&s.view.tf, tables);
    iso_view views[2] = {s.view, s.view};
    views[0].tf = tables[0], views[1].tf = tables[1];
    assert_int_equal(mkdir(made, 0777), 0);
    iso_blender_options opt = iso_blender_defaults();
    assert_ok(iso_blender_export_levels(&s.pyramid, &(iso_blender_levels){0, 2, views}, first, &opt, NULL, &err));
    assert_int_equal(rename(made, moved), 0);
    run_script(blend, user_script);

    iso_image want = reference(&s, 0, &s.view), have = load(moved, "level_0.exr");
    assert_at_most(rmse_of_color(&have, &want), SMOOTH_LIMIT);
    iso_image_destroy(&have);
    have = load(moved, "level_1.exr");
    assert_more_than(rmse_of_color(&have, &want), SMOOTH_LIMIT); /* else nothing was switched */
    iso_image_destroy(&want);
    iso_view coarse = s.view;
    coarse.tf = tables[1];
    want = reference(&s, 1, &coarse);
    assert_at_most(rmse_of_color(&have, &want), SMOOTH_LIMIT);
    iso_image_destroy(&have);
    have = load(moved, "turned.exr");
    assert_at_most(rmse_of_color(&have, &want), SMOOTH_LIMIT);
    iso_image_destroy(&have);
    iso_image_destroy(&want);

    /* Level 1 has a ramp of its own, within a thousandth of its table. */
    want = reference(&s, 1, &coarse);
    have = load(moved, "ramp.exr");
    assert_at_most(rmse_of_color(&have, &want), 1e-3);
    iso_image_destroy(&have);
    iso_image_destroy(&want);
    free(tables[0].entries);
    free(tables[1].entries);
}

static iso_status export_level(const subject *s, size_t level, const char *path, const iso_blender_options *opt,
                               iso_error *err)
{
    return iso_blender_export_levels(&s->pyramid, &(iso_blender_levels){level, 1, &s->view}, path, opt, NULL, err);
}

/* The .blend says in digits to be read where its origin lies; camera, box and suns are there with the volume. */
VALUES_TEST(a_volume_far_from_the_origin_agrees_and_so_does_its_file)
{
    need_cycles();
    check_case(&far_away, SMOOTH_LIMIT);
    ENDED_BY(close_subject) subject s = open_subject(&far_away);
    FREED char *blend = iso_path_join(s.dir, "far.blend");
    iso_blender_options opt = iso_blender_defaults();
    assert_ok(export_level(&s, 0, blend, &opt, &err));
    const iso_vec3 center = iso_geometry_box_center_mm(&s.pyramid.levels[0].geometry);
    char script[2000];
    snprintf(script, sizeof script,
             "import bpy\n"
             "scene, frame, center = bpy.context.scene, bpy.data.objects['far'], (%.17g, %.17g, %.17g)\n"
             "origin = [round(o) for o in scene['isoshade_origin_mm']]\n"
             "assert '(%%d, %%d, %%d) of the world' %% tuple(origin) in bpy.data.texts['README'].as_string()\n"
             "middle = [sum(v.co[a] for v in frame.data.vertices) / 8 for a in range(3)]\n"
             "assert all(abs(o + m - c) < 1e-5 for o, m, c in zip(origin, middle, center)), (origin, middle, center)\n"
             "for thing in bpy.data.objects:\n"
             "    assert thing.matrix_world.to_translation().length < 50, thing.name\n"
             "exec(bpy.data.texts['isoshade agreement'].as_string())\n"
             "scene.render.filepath = '//far.exr'\n"
             "bpy.ops.render.render(write_still=True)\n",
             center.x, center.y, center.z);
    run_script(blend, script);
    OWNED(iso_image) want = reference(&s, 0, &s.view), have = load(s.dir, "far.exr");
    assert_at_most(rmse_of_color(&have, &want), SMOOTH_LIMIT);
}

static void check_nothing_left(const char *dir, const char *stem)
{
    FREED char *blend = NULL, *vdb = NULL;
    assert_true(asprintf(&blend, "%s/%s.blend", dir, stem) > 0 && asprintf(&vdb, "%s/%s.vdb", dir, stem) > 0);
    assert_false(iso_path_exists(blend));
    assert_false(iso_path_exists(vdb));
}

TEST(failures_are_told_and_leave_no_file)
{
    need_cycles();
    ENDED_BY(close_subject)
    subject s = open_subject(&(scene_case){.field = ISO_FIELD_SPHERE, .type = ISO_F32, .tf = soft_tf});
    iso_blender_options opt = iso_blender_defaults();
    iso_image image;
    FREED char *blend = iso_path_join(s.dir, "v.blend"), *odd = iso_path_join(s.dir, "v.vdb");
    FREED char *lost = iso_path_join(s.dir, "missing/v.blend");
    assert_status(export_level(&s, 0, odd, &opt, &err), ISO_E_USAGE);
    assert_status(export_level(&s, 0, lost, &opt, &err), ISO_E_IO);
    assert_status(export_level(&s, 2, blend, &opt, &err), ISO_E_RANGE);
    opt.step_voxels = 1e-4;
    assert_status(iso_cycles_render(&s.pyramid, 0, &s.view, &opt, &image, NULL, &err), ISO_E_RANGE);
    opt = iso_blender_defaults();
    setenv("ISOSHADE_BLENDER", "/nonexistent/blender", 1);
    assert_status(iso_cycles_render(&s.pyramid, 0, &s.view, &opt, &image, NULL, &err), ISO_E_MISSING);
    assert_null(image.rgba);
    assert_status(export_level(&s, 0, blend, &opt, &err), ISO_E_MISSING);
    setenv("ISOSHADE_BLENDER", "/bin/false", 1);
    assert_status(export_level(&s, 0, blend, &opt, &err), ISO_E_PROGRAM);
    unsetenv("ISOSHADE_BLENDER");
    check_nothing_left(s.dir, "v");
}

/* A Blender that puts grids somewhere new: its script is changed on the way to it. */
TEST(a_blender_that_puts_voxels_elsewhere_is_refused)
{
    need_cycles();
    ENDED_BY(close_subject)
    subject s = open_subject(&(scene_case){.field = ISO_FIELD_SPHERE, .type = ISO_F32, .tf = soft_tf});
    FREED char *wrapper = iso_path_join(s.dir, "blender"), *blender = NULL, *text = NULL;
    assert_ok(iso_process_find("blender", "blender", &blender, &err));
    int n = asprintf(
        &text,
        "#!/bin/sh\n"
        "sed -i 's/^\\( *\\)thing.data.render.step_size = 0.125/&\\n\\1thing.location = (0.2, 0, 0)/' build_scene.py\n"
        "exec %s \"$@\"\n",
        blender);
    assert_true(n > 0);
    assert_ok(iso_file_write(wrapper, text, (size_t)n, &err));
    assert_int_equal(chmod(wrapper, 0755), 0);
    setenv("ISOSHADE_BLENDER", wrapper, 1);
    iso_image image;
    iso_blender_options opt = iso_blender_defaults();
    assert_status(iso_cycles_render(&s.pyramid, 0, &s.view, &opt, &image, NULL, &err), ISO_E_UNTRUSTED);
    unsetenv("ISOSHADE_BLENDER");
}

TEST(the_version_is_a_number)
{
    char version[32];
    assert_ok(iso_blender_version(NULL, version, sizeof version, &err));
    assert_more_than(atof(version), 2.8);
}

TEST_MAIN(NULL, NULL)
